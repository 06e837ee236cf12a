#include "base/error.h"
#include "io/header_text.h"
#include "io/nrrd_header.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"

namespace vol::io {
namespace {

std::string_view type_name(volume::VoxelType type) {
  using enum volume::VoxelType;
  switch (type) {
    case i8:
      return "int8";
    case u8:
      return "uint8";
    case i16:
      return "int16";
    case u16:
      return "uint16";
    case i32:
      return "int32";
    case u32:
      return "uint32";
    case f32:
      return "float";
    case f64:
      return "double";
    case f16:
      break;
  }
  throw Error("NRRD has no 16-bit float; convert the volume to f32");
}

/// Key/value pairs; what the syntax of the header cannot hold is left out with a warning.
std::string attribute_lines(const volume::Volume& volume, Warnings& warnings) {
  std::string lines;
  for (const auto& [key, value] : volume.attributes) {
    const bool content = key == "content" && value.find('\n') == std::string::npos && trimmed(value) == value;
    const bool holdable = !key.empty() && key[0] != '#' && key.find(':') == std::string::npos &&
                          key.find('\r') == std::string::npos && (value.empty() || value.back() != '\r');
    if (content) {
      lines += "content: " + value + "\n";
    } else if (holdable) {
      lines += nrrd::escaped(key) + ":=" + nrrd::escaped(value) + "\n";
    } else {
      warnings.push_back("NRRD cannot hold the attribute " + in_quotes(key) + "; it is left out");
    }
  }
  return lines;
}

std::string header_text(const volume::Volume& volume, bool compress, const std::string& data_file,
                        Warnings& warnings) {
  const volume::GridGeometry& g = volume.geometry();
  const Mat3 steps = g.direction * g.spacing.asDiagonal();
  std::string text = "NRRD0005\ntype: " + std::string(type_name(volume.voxel_type())) + "\ndimension: 3\n";
  switch (g.space) {
    case volume::Space::lps:
      text += "space: left-posterior-superior\n";
      break;
    case volume::Space::ras:
      text += "space: right-anterior-superior\n";
      break;
    case volume::Space::none:
      text += "space dimension: 3\n";
      break;
  }
  text += "sizes: " + std::to_string(g.dims[0]) + " " + std::to_string(g.dims[1]) + " " +
          std::to_string(g.dims[2]) + "\n";
  text += "space directions: (" + shortest(steps.col(0), ",") + ") (" + shortest(steps.col(1), ",") + ") (" +
          shortest(steps.col(2), ",") + ")\n";
  text += "kinds: domain domain domain\n";
  if (volume::size_in_bytes(volume.voxel_type()) > 1) text += "endian: little\n";
  text += std::string("encoding: ") + (compress ? "gzip" : "raw") + "\n";
  text += "space origin: (" + shortest(g.origin, ",") + ")\n";
  text += attribute_lines(volume, warnings);
  if (!data_file.empty()) text += "data file: " + data_file + "\n";
  return text + "\n";
}

void write_voxels(OutputFile& out, const volume::Volume& volume, bool compress) {
  with_voxel_bytes(volume, [&](const void* data, std::size_t n) {
    if (compress) {
      deflate_to(data, n, true, [&](const void* part, std::size_t size) { out.write(part, size); });
    } else {
      out.write(data, n);
    }
  });
}

}  // namespace

Warnings write_nrrd(const std::filesystem::path& path, const volume::Volume& volume, bool detached,
                    bool compress) {
  Warnings warnings;
  if (!detached) {
    OutputFile out(path);
    out.write(header_text(volume, compress, {}, warnings));
    write_voxels(out, volume, compress);
    out.commit();
    return warnings;
  }
  std::filesystem::path data_path = path;
  data_path.replace_extension(compress ? ".raw.gz" : ".raw");
  OutputFile data(data_path);
  write_voxels(data, volume, compress);
  OutputFile header(path);
  header.write(header_text(volume, compress, data_path.filename().string(), warnings));
  data.commit();
  header.commit();
  return warnings;
}

}  // namespace vol::io
