// NIfTI-1, after nifti1.h (nifti.nimh.nih.gov): field offsets, types, the three ways to world coordinates.
#include <array>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "base/parallel.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

constexpr std::size_t kHeaderSize = 348;

/// Field access by offset, in the byte order that dim[0] or the header size shows.
class Header {
 public:
  std::array<unsigned char, kHeaderSize> bytes{};
  bool big_endian = false;

  template <class T>
  [[nodiscard]] T get(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw;
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[big_endian ? sizeof(T) - 1 - i : i] = bytes[offset + i];
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  [[nodiscard]] std::int16_t dim(std::size_t i) const { return get<std::int16_t>(40 + 2 * i); }
  [[nodiscard]] float pixdim(std::size_t i) const { return get<float>(76 + 4 * i); }
  [[nodiscard]] std::string_view magic() const {
    return {reinterpret_cast<const char*>(bytes.data()) + 344, 4};
  }
};

std::int32_t size_field(const unsigned char* bytes, bool big_endian) {
  Header header;
  std::memcpy(header.bytes.data(), bytes, 4);
  header.big_endian = big_endian;
  return header.get<std::int32_t>(0);
}

Header read_header(ByteSource& source) {
  Header header;
  const std::size_t got = source.read(header.bytes.data(), kHeaderSize);
  const std::string& name = source.name();
  if (got >= 4) {
    header.big_endian = size_field(header.bytes.data(), true) == 348;
    const std::int32_t size = header.get<std::int32_t>(0);
    if (size == 540 || size_field(header.bytes.data(), true) == 540) {
      throw Error(name + ": is NIfTI-2, expected NIfTI-1");
    }
    if (size != 348)
      throw Error(name + ": is no NIfTI-1 file (header size " + std::to_string(size) + ", expected 348)");
  }
  if (got != kHeaderSize) {
    throw Error(name + ": NIfTI header ends after " + std::to_string(got) + " of 348 bytes");
  }
  if (header.magic() != std::string_view("n+1\0", 4) && header.magic() != std::string_view("ni1\0", 4)) {
    throw Error(name + ": has no NIfTI-1 magic word (is " + in_quotes(header.magic()) +
                "), so that nothing says where its samples lie");
  }
  return header;
}

volume::VoxelType voxel_type(const std::string& name, const Header& header) {
  const std::int16_t code = header.get<std::int16_t>(70);
  switch (code) {
    case 2:
      return volume::VoxelType::u8;
    case 4:
      return volume::VoxelType::i16;
    case 8:
      return volume::VoxelType::i32;
    case 16:
      return volume::VoxelType::f32;
    case 64:
      return volume::VoxelType::f64;
    case 256:
      return volume::VoxelType::i8;
    case 512:
      return volume::VoxelType::u16;
    case 768:
      return volume::VoxelType::u32;
    default:
      break;
  }
  throw Error(name + ": NIfTI datatype is " + std::to_string(code) +
              ", expected a real scalar: 2, 4, 8, 16, 64, 256, 512 or 768");
}

/// Method 2: rotation from the quaternion (b, c, d), a = sqrt(1 - b^2 - c^2 - d^2); pixdim[0] = -1 flips the
/// third axis.
void set_qform(volume::GridGeometry& geometry, const Header& header) {
  Vec3 v(header.get<float>(256), header.get<float>(260), header.get<float>(264));
  double a = std::sqrt(std::max(0.0, 1.0 - v.squaredNorm()));
  if (v.squaredNorm() > 1.0) {  // a half turn, to rounding
    v.normalize();
    a = 0.0;
  }
  geometry.direction = Eigen::Quaterniond(a, v.x(), v.y(), v.z()).toRotationMatrix();
  if (header.pixdim(0) < 0) geometry.direction.col(2) *= -1;
  geometry.origin = {header.get<float>(268), header.get<float>(272), header.get<float>(276)};
  geometry.space = volume::Space::ras;
}

volume::GridGeometry parse_geometry(const std::string& name, const Header& header) {
  const std::int16_t axes = header.dim(0);
  if (axes < 1 || axes > 7) throw Error(name + ": NIfTI dim[0] is " + std::to_string(axes) + ", expected 3");
  volume::GridGeometry geometry;
  for (std::size_t a = 0; a < 3; ++a)
    geometry.dims[a] = static_cast<std::int16_t>(a) < axes ? header.dim(a + 1) : 1;
  for (std::size_t a = 5; a <= static_cast<std::size_t>(axes); ++a) {
    if (header.dim(a) > 1) {
      throw Error(name + ": NIfTI dim[" + std::to_string(a) + "] is " + std::to_string(header.dim(a)) +
                  ", expected a scalar volume");
    }
  }
  if (header.get<std::int16_t>(254) > 0) {  // method 3, the affine matrix by rows
    Mat3 steps;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        steps(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
            header.get<float>(280 + 16 * row + 4 * column);
      }
      geometry.origin[static_cast<Eigen::Index>(row)] = header.get<float>(280 + 16 * row + 12);
    }
    if (!steps.allFinite()) throw Error(name + ": NIfTI sform is not finite");
    set_axes(geometry, steps);
    geometry.space = volume::Space::ras;
    return geometry;
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const float step = header.pixdim(a + 1);
    geometry.spacing[static_cast<Eigen::Index>(a)] = geometry.dims[a] == 1 && step == 0 ? 1.0 : step;
  }
  if (header.get<std::int16_t>(252) > 0) set_qform(geometry, header);
  return geometry;
}

/// scl_slope x + scl_inter, where they say anything: f32, or f64 from types that f32 does not hold.
volume::Volume scaled(volume::Volume volume, double slope, double intercept) {
  const auto type = volume.voxel_type();
  const bool wide =
      type == volume::VoxelType::i32 || type == volume::VoxelType::u32 || type == volume::VoxelType::f64;
  return volume::dispatch(wide ? volume::VoxelType::f64 : volume::VoxelType::f32, [&]<class To>() {
    volume::Volume result;
    if constexpr (std::is_floating_point_v<To>) {
      volume::visit(volume, [&](const auto& from) {
        volume::Grid<To> to{from.geometry, Buffer<To>(from.voxels.size())};
        parallel_for(0, from.geometry.count(), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
          for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
            to.voxels[n] = static_cast<To>(slope * static_cast<double>(from.voxels[n]) + intercept);
          }
        });
        result.grid = std::move(to);
      });
    }
    return result;
  });
}

std::filesystem::path image_beside(const std::filesystem::path& header) {
  std::filesystem::path image = header;
  if (image.extension() == ".gz") image.replace_extension();
  image.replace_extension(".img");
  std::error_code ignored;
  if (!std::filesystem::exists(image, ignored) && std::filesystem::exists(image.string() + ".gz", ignored)) {
    image += ".gz";
  }
  return image;
}

bool starts_gzip(InputFile& file) {
  return file.peek(2) == "\x1f\x8b";
}

/// Data of `volume_count` volumes in `source` from `offset` on, of which one is read.
volume::Volume read_data(ByteSource& source, std::int64_t consumed, const Header& header,
                         const VoxelLayout& layout, const ReadOptions& options) {
  const std::string& name = source.name();
  const std::int64_t bytes = checked_bytes(name, layout, options);
  const std::int64_t volumes = header.dim(0) >= 4 ? header.dim(4) : 1;
  if (volumes < 1) throw Error(name + ": NIfTI dim[4] is " + std::to_string(volumes) + ", expected 1");
  if (volumes > 1 && !options.volume) {
    throw Error(name + ": holds " + std::to_string(volumes) + " volumes; choose one with --volume 0 ... " +
                std::to_string(volumes - 1));
  }
  const std::int64_t chosen = options.volume.value_or(0);
  if (chosen < 0 || chosen >= volumes) {
    throw Error(name + ": has no volume " + std::to_string(chosen) + "; there are 0 ... " +
                std::to_string(volumes - 1));
  }
  const double offset = static_cast<double>(header.get<float>(108));
  const bool alone = header.magic()[1] == 'i';  // data in their own file
  if (!(offset >= (alone ? 0.0 : 352.0)) && !(offset == 0.0)) {
    throw Error(name + ": NIfTI vox_offset is " + shortest(offset) + ", expected at least 352");
  }
  if (!(offset < 1e15)) throw Error(name + ": NIfTI vox_offset is " + shortest(offset) + ", beyond any file");
  const std::int64_t start = alone ? static_cast<std::int64_t>(offset)
                                   : std::max<std::int64_t>(352, static_cast<std::int64_t>(offset));
  source.skip(start - consumed);
  for (std::int64_t n = 0; n < chosen; ++n) source.skip(bytes);
  volume::Volume volume = read_binary(source, layout, options);
  if (chosen == volumes - 1) expect_end(source, bytes);
  return volume;
}

volume::Volume read_from(InputFile& file, ByteSource& source, const ReadOptions& options) {
  const Header header = read_header(source);
  const std::string& name = source.name();
  VoxelLayout layout;
  layout.type = voxel_type(name, header);
  layout.geometry = parse_geometry(name, header);
  layout.big_endian = header.big_endian;
  volume::Volume volume;
  if (header.magic()[1] == 'i') {
    (void)checked_bytes(name, layout, options);
    const auto image =
        open_data_file(image_beside(is_standard_stream(file.path()) ? "standard-input.hdr" : file.path()));
    FileSource plain(*image);
    if (starts_gzip(*image)) {
      InflateSource inflated(plain);
      volume = read_data(inflated, 0, header, layout, options);
    } else {
      volume = read_data(plain, 0, header, layout, options);
    }
  } else {
    volume = read_data(source, kHeaderSize, header, layout, options);
  }
  const double slope = header.get<float>(112), intercept = header.get<float>(116);
  const bool says_something =
      std::isfinite(slope) && slope != 0 && std::isfinite(intercept) && !(slope == 1 && intercept == 0);
  if (says_something) volume = scaled(std::move(volume), slope, intercept);
  const auto* text = reinterpret_cast<const char*>(header.bytes.data()) + 148;
  const std::string_view description = trimmed({text, ::strnlen(text, 80)});
  if (!description.empty()) volume.attributes["description"] = description;
  return volume;
}

}  // namespace

bool is_nifti(std::string_view start) {
  if (start.compare(0, 2, "\x1f\x8b") == 0) return true;
  if (start.size() < 4) return false;
  const auto* bytes = reinterpret_cast<const unsigned char*>(start.data());
  for (const bool big : {false, true}) {
    const std::int32_t size = size_field(bytes, big);
    if (size == 348 || size == 540) return true;
  }
  return false;
}

volume::Volume read_nifti(InputFile& file, const ReadOptions& options) {
  FileSource source(file);
  if (!starts_gzip(file)) return read_from(file, source, options);
  InflateSource inflated(source);
  return read_from(file, inflated, options);
}

}  // namespace vol::io
