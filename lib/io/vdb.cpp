// The one translation unit that sees OpenVDB: its headers take half a minute to compile.
#include "io/vdb.h"

#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/checked.h"
#include "base/error.h"
#include "io/vdb_bytes.h"
#include "io/vdb_metadata.h"
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

void initialize() {
  static const bool done = [] {
    openvdb::initialize();
    return true;
  }();
  (void)done;
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
  openvdb::GridPtrVec grids;
  Metadata metadata;  // the string ones of the file
};

Archive read_archive(InputFile& file, std::int64_t limit) {
  if (!is_vdb(file.peek(kVdbMagic.size()))) throw Error("not an OpenVDB file");
  std::vector<std::byte> bytes = file.read_rest(effective_limit(limit));
  if (!is_intact(bytes))
    throw Error("OpenVDB data end early or are damaged: their content does not match their id");
  check_vdb_structure(bytes);
  initialize();
  MemoryInput source(bytes);
  std::istream in(&source);
  in.exceptions(std::ios::failbit | std::ios::badbit |
                std::ios::eofbit);  // OpenVDB itself reads on past the end
  openvdb::io::Stream stream(in, false);
  Archive archive;
  if (const auto grids = stream.getGrids()) archive.grids = *grids;
  if (const auto metadata = stream.getMetadata()) {
    for (auto it = metadata->beginMeta(); it != metadata->endMeta(); ++it) {
      if (it->second && it->second->typeName() == openvdb::StringMetadata::staticTypeName()) {
        archive.metadata[it->first] = static_cast<const openvdb::StringMetadata&>(*it->second).value();
      }
    }
  }
  std::erase(archive.grids, nullptr);
  return archive;
}

void write_archive(const std::filesystem::path& path, const openvdb::GridPtrVec& grids,
                   const Metadata& metadata) {
  openvdb::MetaMap meta;
  for (const auto& [key, value] : metadata) meta.insertMeta(key, openvdb::StringMetadata(value));
  MemoryOutput sink;
  std::ostream to(&sink);
  openvdb::io::Stream stream(to);
  stream.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
  stream.write(grids, meta);
  set_content_id(sink.bytes);
  OutputFile out(path);
  out.write(sink.bytes);
  out.commit();
}

/// Index to world as OpenVDB wants it: row vectors, p' = p M. A matrix so small that OpenVDB takes it for
/// singular is left out: the metadata hold the geometry.
openvdb::math::Transform::Ptr transform_of(const GridGeometry& g) {
  const Mat3 axes = g.direction * g.spacing.asDiagonal();
  openvdb::Mat4R m = openvdb::Mat4R::identity();
  for (int axis = 0; axis < 3; ++axis) {
    for (int c = 0; c < 3; ++c) m[axis][c] = axes(c, axis);
    m[3][axis] = g.origin[axis];
  }
  try {
    return openvdb::math::Transform::createLinearTransform(m);
  } catch (const openvdb::Exception&) {
    return openvdb::math::Transform::createLinearTransform(1.0);
  }
}

openvdb::CoordBBox box_of(const std::array<std::int64_t, 3>& lower, const Dims& dims) {
  openvdb::CoordBBox box;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t upper = lower[a] + dims[a] - 1;
    if (std::abs(lower[a]) > kLargestCoordinate / 2 || dims[a] > kLargestCoordinate / 2) {
      throw Error("an axis of " + std::to_string(dims[a]) + " is more than an OpenVDB grid holds");
    }
    box.min()[a] = static_cast<std::int32_t>(lower[a]);
    box.max()[a] = static_cast<std::int32_t>(upper);
  }
  return box;
}

template <class T>
using GridOf = std::conditional_t<std::is_same_v<T, float>, openvdb::FloatGrid, openvdb::DoubleGrid>;
template <class T>
using DenseOf = openvdb::tools::Dense<T, openvdb::tools::LayoutXYZ>;

/// The samples as a sparse grid; zeros are background.
template <class T>
openvdb::GridBase::Ptr sparse(const Buffer<T>& samples, const openvdb::CoordBBox& box,
                              const std::string& name) {
  auto grid = GridOf<T>::create(T{0});
  const DenseOf<T> dense(box, const_cast<T*>(samples.data()));
  openvdb::tools::copyFromDense(dense, *grid, T{0});
  grid->setName(name);
  return grid;
}

/// The box of a grid, dense, into `to`; throws where active voxels lie outside it.
template <class T>
void densify(const GridOf<T>& grid, const openvdb::CoordBBox& box, Buffer<T>& to) {
  openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
  if (!active.empty() && !box.isInside(active)) {
    throw Error("grid '" + grid.getName() + "' has voxels outside the dims of its metadata");
  }
  DenseOf<T> dense(box, to.data());
  openvdb::tools::copyToDense(grid, dense);
}

template <class T>
Volume dense_volume(const GridOf<T>& grid, const GridGeometry& geometry, const openvdb::CoordBBox& box) {
  Volume volume;
  Grid<T> dense{geometry, Buffer<T>(static_cast<std::size_t>(geometry.count()))};
  densify<T>(grid, box, dense.voxels);
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

bool is_scalar(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

const openvdb::GridBase& chosen(const Archive& archive, const std::string& array) {
  std::string names;
  for (const auto& grid : archive.grids) {
    if (is_scalar(*grid) && (array.empty() || grid->getName() == array)) return *grid;
    names += (names.empty() ? "" : ", ") + grid->getName() + " (" + grid->valueType() + ")";
  }
  throw Error(
      (array.empty() ? std::string("no float or double grid") : "no float or double grid '" + array + "'") +
      "; there are: " + (names.empty() ? "none" : names));
}

/// Where the voxels of a foreign grid lie: its box of active voxels under its linear transform.
GridGeometry foreign_geometry(const openvdb::GridBase& grid, const openvdb::CoordBBox& box) {
  if (!grid.transform().isLinear())
    throw Error("grid '" + grid.getName() + "' has a transform that is not linear");
  const openvdb::Mat4R m = grid.transform().baseMap()->getAffineMap()->getMat4();
  GridGeometry g;
  Mat3 axes;
  for (int axis = 0; axis < 3; ++axis) {
    g.dims[axis] = std::int64_t{box.max()[axis]} - box.min()[axis] + 1;
    for (int c = 0; c < 3; ++c) axes(c, axis) = m[axis][c];
    g.spacing[axis] = axes.col(axis).norm();
    g.direction.col(axis) = axes.col(axis) / g.spacing[axis];
    g.origin[axis] = m[3][axis];
  }
  g.origin += axes * Vec3(box.min()[0], box.min()[1], box.min()[2]);
  g.validate();
  return g;
}

Volume volume_from(const Archive& archive, const VdbOptions& options) {
  const auto content = archive.metadata.find(kContentKey);
  if (content != archive.metadata.end() && content->second == "coefficients") {
    throw Error("holds wavelet coefficients; use vol-dwt --inverse");
  }
  const openvdb::GridBase& base = chosen(archive, options.array);
  const bool own = content != archive.metadata.end() && content->second == "volume";
  openvdb::CoordBBox box = base.evalActiveVoxelBoundingBox();
  if (!own && box.empty()) throw Error("grid '" + base.getName() + "' has no active voxels");
  const GridGeometry geometry = own ? geometry_from(archive.metadata) : foreign_geometry(base, box);
  if (own) box = box_of({0, 0, 0}, geometry.dims);
  require_memory(checked_product(checked_count(geometry.dims), base.isType<openvdb::FloatGrid>() ? 4 : 8),
                 options.memory_limit, "the dense box of grid '" + base.getName() + "'");
  Volume volume = base.isType<openvdb::FloatGrid>()
                      ? dense_volume<float>(static_cast<const openvdb::FloatGrid&>(base), geometry, box)
                      : dense_volume<double>(static_cast<const openvdb::DoubleGrid&>(base), geometry, box);
  if (own) volume = as_type(std::move(volume), voxel_type_from(archive.metadata));
  for (const auto& [key, value] : archive.metadata) {
    if (!is_own_key(key)) volume.attributes[key] = value;
  }
  return volume;
}

template <class T>
void write_decomposition(const std::filesystem::path& path, const wavelet::Decomposition<T>& decomposition,
                         const Attributes& attributes) {
  guarded(output_name(path), [&] {
    initialize();
    Metadata metadata = attributes;
    put_decomposition(metadata, decomposition);
    openvdb::GridPtrVec grids;
    for (const auto& s : decomposition.subbands) {
      const auto finite = [](T c) { return std::isfinite(c); };
      if (!std::all_of(s.coefficients.begin(), s.coefficients.end(), finite)) {
        throw Error("subband " + subband_name(s.level, s.orientation) +
                    " has coefficients that are NaN or infinite");
      }
      grids.push_back(sparse(s.coefficients, box_of(s.lower, s.dims), subband_name(s.level, s.orientation)));
    }
    write_archive(path, grids, metadata);
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
    for (const auto& grid : archive.grids) {
      if (grid->getName() != name) continue;
      if (!grid->isType<GridOf<T>>())
        throw Error("grid '" + name + "' has another value type than the first");
      densify<T>(static_cast<const GridOf<T>&>(*grid), box_of(s.lower, s.dims), s.coefficients);
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
    initialize();
    const VoxelType type = volume.voxel_type();
    const GridGeometry& geometry = volume.geometry();
    Metadata metadata = volume.attributes;
    metadata[kContentKey] = "volume";
    put_volume(metadata, geometry, type, volume::value_range(volume));
    const auto box = box_of({0, 0, 0}, geometry.dims);
    const bool wide = type == VoxelType::i32 || type == VoxelType::u32 || type == VoxelType::f64;
    openvdb::GridBase::Ptr grid;
    if (const auto* f32 = std::get_if<Grid<float>>(&volume.grid)) {
      grid = sparse(f32->voxels, box, "density");
    } else if (const auto* f64 = std::get_if<Grid<double>>(&volume.grid)) {
      grid = sparse(f64->voxels, box, "density");
    } else if (wide) {
      grid = sparse(volume::converted<double>(volume).voxels, box, "density");
    } else {
      grid = sparse(volume::converted<float>(volume).voxels, box, "density");
    }
    grid->setTransform(transform_of(geometry));
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    write_archive(path, {grid}, metadata);
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
    const Archive archive = read_archive(file, memory_limit);
    const auto content = archive.metadata.find(kContentKey);
    if (content == archive.metadata.end() || content->second != "coefficients") {
      throw Error("holds no wavelet coefficients; make them with vol-dwt");
    }
    Coefficients result;
    const bool wide = !archive.grids.empty() && archive.grids.front()->isType<openvdb::DoubleGrid>();
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
