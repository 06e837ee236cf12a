#include "io/vdb.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/checked.h"
#include "base/error.h"
#include "io/header_text.h"
#include "io/vdb_bytes.h"
#include "io/vdb_metadata.h"
#include "io/vdb_module.h"
#include "io/vdb_structure.h"

namespace vol::io {
namespace {

using volume::Grid;
using volume::GridGeometry;
using volume::Volume;
using volume::VoxelType;

constexpr std::int64_t kLargestCoordinate = std::numeric_limits<std::int32_t>::max();

std::int64_t effective_limit(std::int64_t limit) {
  return limit > 0 ? limit : static_cast<std::int64_t>(::sysconf(_SC_PHYS_PAGES)) * ::sysconf(_SC_PAGE_SIZE);
}

void require_memory(std::int64_t bytes, std::int64_t limit, const std::string& what) {
  const std::int64_t most = effective_limit(limit);
  if (bytes > most) {
    throw Error(what + " takes " + std::to_string(bytes) + " bytes of memory, more than the limit of " +
                std::to_string(most));
  }
}

/// OpenVDB, loaded on first use. Never closed: its types register themselves in ways that do not survive it.
const VdbModule& openvdb_module() {
  static const VdbModule loaded = [] {
    void* const library = ::dlopen(kVdbModule, RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
      throw Error(std::string("OpenVDB cannot be loaded: ") + ::dlerror() +
                  " (it belongs in ../lib/precis beside the programs)");
    }
    const auto fill = reinterpret_cast<FillVdbModule>(::dlsym(library, kVdbEntry));
    if (fill == nullptr) throw Error(std::string(kVdbModule) + " is of another version: install Precis anew");
    VdbModule module;
    fill(&module);
    return module;
  }();
  return loaded;
}

/// Runs work on a file; every failure becomes one line that names it.
template <class Work>
auto guarded(const std::string& name, Work&& work) {
  try {
    return work();
  } catch (const Error& e) {
    throw Error(name, e);
  } catch (const std::ios_base::failure&) {
    throw Error(name + ": OpenVDB data end early or are damaged");
  } catch (const std::bad_alloc&) {
    throw Error(name + ": not enough memory; the OpenVDB data may be damaged");
  } catch (const std::exception& e) {
    const std::string_view what = e.what();
    throw Error(name + ": not readable OpenVDB data: " + std::string(what.substr(0, what.find('\n'))));
  }
}

struct Archive {
  std::unique_ptr<VdbArchive> grids;
  Metadata metadata;  // the string ones of the file
};

Archive read_archive(InputFile& file, std::int64_t limit) {
  if (!is_vdb(file.peek(kVdbMagic.size()))) throw Error("not an OpenVDB file");
  std::vector<std::byte> bytes = file.read_rest(effective_limit(limit));
  if (!is_intact(bytes))
    throw Error("OpenVDB data end early or are damaged: their content does not match their id");
  check_vdb_structure(bytes);
  Archive archive{openvdb_module().read(bytes), {}};
  archive.metadata = archive.grids->metadata();
  return archive;
}

void write_archive(const std::filesystem::path& path, const VdbGrids& grids, const Metadata& metadata) {
  std::string bytes = grids.file(metadata);
  set_content_id(bytes);
  OutputFile out(path);
  out.write(bytes);
  out.commit();
}

VdbMatrix matrix_of(const GridGeometry& g) {
  const Mat3 axes = g.direction * g.spacing.asDiagonal();
  VdbMatrix m{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<std::size_t>(axis);
    for (int c = 0; c < 3; ++c) m[row][static_cast<std::size_t>(c)] = axes(c, axis);
    m[3][row] = g.origin[axis];
  }
  m[3][3] = 1;
  return m;
}

VdbBox box_of(const std::array<std::int64_t, 3>& lower, const Dims& dims) {
  VdbBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::abs(lower[a]) > kLargestCoordinate / 2 || dims[a] > kLargestCoordinate / 2) {
      throw Error("an axis of " + std::to_string(dims[a]) + " is more than an OpenVDB grid holds");
    }
    box.lower[a] = static_cast<std::int32_t>(lower[a]);
    box.upper[a] = static_cast<std::int32_t>(lower[a] + dims[a] - 1);
  }
  return box;
}

bool is_inside(const VdbBox& inner, const VdbBox& outer) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (inner.lower[a] < outer.lower[a] || inner.upper[a] > outer.upper[a]) return false;
  }
  return true;
}

template <class T>
constexpr std::string_view kValueType = std::is_same_v<T, float> ? "float" : "double";

/// The box of a grid, dense, into `to`; throws where active voxels lie outside it.
template <class T>
void densify(const VdbArchive& archive, std::size_t grid, const VdbBox& box, Buffer<T>& to) {
  const VdbBox active = archive.active_box(grid);
  if (!active.empty() && !is_inside(active, box)) {
    throw Error("grid " + in_quotes(archive.name(grid)) + " has voxels outside the dims of its metadata");
  }
  archive.densify(grid, box, to.data());
}

template <class T>
Volume dense_volume(const VdbArchive& archive, std::size_t grid, const GridGeometry& geometry,
                    const VdbBox& box) {
  Volume volume;
  Grid<T> dense{geometry, Buffer<T>(static_cast<std::size_t>(geometry.count()))};
  densify<T>(archive, grid, box, dense.voxels);
  volume.grid = std::move(dense);
  return volume;
}

Volume as_type(Volume&& volume, VoxelType type) {
  if (volume.voxel_type() == type) return std::move(volume);
  return volume::dispatch(type, [&]<class T>() {
    Volume result;
    result.grid = volume::converted<T>(volume);
    return result;
  });
}

/// The number of the grid to read.
std::size_t chosen(const VdbArchive& archive, const std::string& array) {
  std::string names;
  for (std::size_t n = 0; n < archive.grid_count(); ++n) {
    const std::string type = archive.value_type(n);
    const bool is_scalar = type == kValueType<float> || type == kValueType<double>;
    if (is_scalar && (array.empty() || archive.name(n) == array)) return n;
    names += (names.empty() ? "" : ", ") + in_quotes(archive.name(n)) + " (" + type + ")";
  }
  throw Error(
      (array.empty() ? std::string("no float or double grid") : "no float or double grid '" + array + "'") +
      "; there are: " + (names.empty() ? "none" : names));
}

/// Where the voxels of a foreign grid lie: its box of active voxels under its linear transform.
GridGeometry foreign_geometry(const VdbArchive& archive, std::size_t grid, const VdbBox& box) {
  const auto m = archive.index_to_world(grid);
  if (!m) throw Error("grid " + in_quotes(archive.name(grid)) + " has a transform that is not linear");
  GridGeometry g;
  Mat3 axes;
  for (int axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<std::size_t>(axis);
    g.dims[row] = std::int64_t{box.upper[row]} - box.lower[row] + 1;
    for (int c = 0; c < 3; ++c) axes(c, axis) = (*m)[row][static_cast<std::size_t>(c)];
    g.spacing[axis] = axes.col(axis).norm();
    g.direction.col(axis) = axes.col(axis) / g.spacing[axis];
    g.origin[axis] = (*m)[3][row];
  }
  g.origin += axes * Vec3(box.lower[0], box.lower[1], box.lower[2]);
  g.validate();
  return g;
}

Volume volume_from(const Archive& read, const VdbOptions& options) {
  const VdbArchive& archive = *read.grids;
  const auto content = read.metadata.find(kContentKey);
  if (content != read.metadata.end() && content->second == "coefficients") {
    throw Error("holds wavelet coefficients; use vol-dwt --inverse");
  }
  const std::size_t grid = chosen(archive, options.array);
  const bool is_float = archive.value_type(grid) == kValueType<float>;
  const bool own = content != read.metadata.end() && content->second == "volume";
  VdbBox box = archive.active_box(grid);
  if (!own && box.empty()) throw Error("grid " + in_quotes(archive.name(grid)) + " has no active voxels");
  const GridGeometry geometry = own ? geometry_from(read.metadata) : foreign_geometry(archive, grid, box);
  if (own) box = box_of({0, 0, 0}, geometry.dims);
  require_memory(checked_product(checked_count(geometry.dims), is_float ? 4 : 8), options.memory_limit,
                 "the dense box of grid " + in_quotes(archive.name(grid)));
  Volume volume = is_float ? dense_volume<float>(archive, grid, geometry, box)
                           : dense_volume<double>(archive, grid, geometry, box);
  if (own) volume = as_type(std::move(volume), voxel_type_from(read.metadata));
  for (const auto& [key, value] : read.metadata) {
    if (!is_own_key(key)) volume.attributes[key] = value;
  }
  return volume;
}

template <class T>
void write_decomposition(const std::filesystem::path& path, const wavelet::Decomposition<T>& decomposition,
                         const Attributes& attributes) {
  guarded(output_name(path), [&] {
    Metadata metadata = attributes;
    put_decomposition(metadata, decomposition);
    const auto grids = openvdb_module().grids();
    for (const auto& s : decomposition.subbands) {
      const auto finite = [](T c) { return std::isfinite(c); };
      if (!std::all_of(s.coefficients.begin(), s.coefficients.end(), finite)) {
        throw Error("subband " + subband_name(s.level, s.orientation) +
                    " has coefficients that are NaN or infinite");
      }
      grids->add(subband_name(s.level, s.orientation), box_of(s.lower, s.dims), s.coefficients.data(),
                 nullptr);
    }
    write_archive(path, *grids, metadata);
  });
}

template <class T>
wavelet::Decomposition<T> dense_decomposition(const Archive& archive, std::int64_t limit) {
  auto d = decomposition_from<T>(archive.metadata);
  std::int64_t bytes = 0;
  for (const auto& s : d.subbands) {
    (void)box_of(s.lower, s.dims);
    require_memory(
        bytes += std::min(checked_product(checked_count(s.dims), sizeof(T)), effective_limit(limit) + 1),
        limit, "the dense transform");
  }
  for (auto& s : d.subbands) {
    s.coefficients.assign(static_cast<std::size_t>(checked_count(s.dims)), T{0});
    const std::string name = subband_name(s.level, s.orientation);
    for (std::size_t n = 0; n < archive.grids->grid_count(); ++n) {
      if (archive.grids->name(n) != name) continue;
      if (archive.grids->value_type(n) != kValueType<T>)
        throw Error("grid '" + name + "' has another value type than the first");
      densify<T>(*archive.grids, n, box_of(s.lower, s.dims), s.coefficients);
    }
  }
  return d;
}

}  // namespace

bool is_vdb(std::string_view first_bytes) {
  return first_bytes.starts_with(kVdbMagic);
}

bool is_coefficients(InputFile& file) {
  const std::string_view head = file.peek(4096);
  const std::size_t at = head.find(kContentKey);
  return is_vdb(head) && at != std::string_view::npos &&
         head.substr(at, 64).find("coefficients") != std::string_view::npos;
}

volume::Volume read_vdb_volume(InputFile& file, const VdbOptions& options) {
  return guarded(display_name(file.path()),
                 [&] { return volume_from(read_archive(file, options.memory_limit), options); });
}

void write_vdb_volume(const std::filesystem::path& path, const volume::Volume& volume) {
  guarded(output_name(path), [&] {
    const VoxelType type = volume.voxel_type();
    const GridGeometry& geometry = volume.geometry();
    Metadata metadata = volume.attributes;
    metadata[kContentKey] = "volume";
    put_volume(metadata, geometry, type, volume::value_range(volume));
    const auto box = box_of({0, 0, 0}, geometry.dims);
    const VdbMatrix matrix = matrix_of(geometry);
    const auto grids = openvdb_module().grids();
    const auto add = [&](const auto& samples) { grids->add("density", box, samples.data(), &matrix); };
    const bool wide = type == VoxelType::i32 || type == VoxelType::u32 || type == VoxelType::f64;
    if (const auto* f32 = std::get_if<Grid<float>>(&volume.grid)) {
      add(f32->voxels);
    } else if (const auto* f64 = std::get_if<Grid<double>>(&volume.grid)) {
      add(f64->voxels);
    } else if (wide) {
      add(volume::converted<double>(volume).voxels);
    } else {
      add(volume::converted<float>(volume).voxels);
    }
    write_archive(path, *grids, metadata);
  });
}

void write_coefficients(const std::filesystem::path& path, const wavelet::Decomposition<float>& decomposition,
                        const Attributes& attributes) {
  write_decomposition(path, decomposition, attributes);
}

void write_coefficients(const std::filesystem::path& path,
                        const wavelet::Decomposition<double>& decomposition, const Attributes& attributes) {
  write_decomposition(path, decomposition, attributes);
}

Coefficients read_coefficients(InputFile& file, std::int64_t memory_limit) {
  return guarded(display_name(file.path()), [&] {
    if (!is_vdb(file.peek(kVdbMagic.size())))
      throw Error("holds no wavelet coefficients; make them with vol-dwt");
    const Archive archive = read_archive(file, memory_limit);
    const auto content = archive.metadata.find(kContentKey);
    if (content == archive.metadata.end() || content->second != "coefficients") {
      throw Error("holds no wavelet coefficients; make them with vol-dwt");
    }
    Coefficients result;
    const bool wide = archive.grids->grid_count() > 0 && archive.grids->value_type(0) == kValueType<double>;
    if (wide) {
      result.decomposition = dense_decomposition<double>(archive, memory_limit);
    } else {
      result.decomposition = dense_decomposition<float>(archive, memory_limit);
    }
    for (const auto& [key, value] : archive.metadata) {
      if (!is_own_key(key)) result.attributes[key] = value;
    }
    return result;
  });
}

Coefficients read_coefficients(const std::filesystem::path& path, std::int64_t memory_limit) {
  InputFile file(path);
  return read_coefficients(file, memory_limit);
}

}  // namespace vol::io
