#include <algorithm>

#include "base/error.h"
#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/voxel_data.h"
#include "io/xml.h"

namespace vol::io {
namespace {

constexpr std::size_t kBlock = 1 << 20;  // bytes a zlib block holds before compression

std::string_view type_name(volume::VoxelType type) {
  using enum volume::VoxelType;
  switch (type) {
    case i8:
      return "Int8";
    case u8:
      return "UInt8";
    case i16:
      return "Int16";
    case u16:
      return "UInt16";
    case i32:
      return "Int32";
    case u32:
      return "UInt32";
    case f32:
      return "Float32";
    case f64:
      return "Float64";
    case f16:
      break;
  }
  throw Error("VTK has no 16-bit float; convert the volume to f32");
}

/// A string array of one value: the numbers of its bytes, then 0.
std::string string_array(const std::string& key, const std::string& value) {
  std::string text = "      <Array type=\"String\" Name=\"" + xml_escaped(key) +
                     "\" NumberOfTuples=\"1\" format=\"ascii\">\n       ";
  for (const char c : value) text += " " + std::to_string(static_cast<int>(static_cast<unsigned char>(c)));
  return text + " 0\n      </Array>\n";
}

std::string field_data(const volume::Volume& volume, Warnings& warnings) {
  auto attributes = volume.attributes;
  if (volume.geometry().space != volume::Space::none) {
    attributes["precis.space"] = std::string(volume::name(volume.geometry().space));
  }
  std::string text;
  for (const auto& [key, value] : attributes) {
    const bool holdable = !key.empty() && value.find('\0') == std::string::npos &&
                          std::all_of(key.begin(), key.end(), [](char c) { return c >= ' ' || c == '\n'; });
    if (holdable) {
      text += string_array(key, value);
    } else {
      warnings.push_back("VTI cannot hold the attribute " + in_quotes(key) + "; it is left out");
    }
  }
  return text.empty() ? text : "    <FieldData>\n" + text + "    </FieldData>\n";
}

/// Voxels as vtkZLibDataCompressor has them: header words, then the blocks.
void write_blocks(OutputFile& out, const void* data, std::size_t n) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::vector<std::uint64_t> header = {(n + kBlock - 1) / kBlock, kBlock, n % kBlock};
  std::vector<unsigned char> packed;
  for (std::size_t at = 0; at < n; at += kBlock) {
    const std::size_t before = packed.size();
    deflate_to(bytes + at, std::min(kBlock, n - at), false, [&](const void* part, std::size_t size) {
      const auto* from = static_cast<const unsigned char*>(part);
      packed.insert(packed.end(), from, from + size);
    });
    header.push_back(packed.size() - before);
  }
  out.write(header.data(), header.size() * sizeof(std::uint64_t));
  out.write(packed.data(), packed.size());
}

}  // namespace

Warnings write_vti(const std::filesystem::path& path, const volume::Volume& volume, bool compress) {
  Warnings warnings;
  const volume::GridGeometry& g = volume.geometry();
  const std::string extent = "0 " + std::to_string(g.dims[0] - 1) + " 0 " + std::to_string(g.dims[1] - 1) +
                             " 0 " + std::to_string(g.dims[2] - 1);
  const Mat3 rows = g.direction.transpose();  // VTK writes the matrix by rows
  const std::string type(type_name(volume.voxel_type()));
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\""
      " header_type=\"UInt64\"";
  if (compress) text += " compressor=\"vtkZLibDataCompressor\"";
  text += ">\n  <ImageData WholeExtent=\"" + extent + "\" Origin=\"" + shortest(g.origin) + "\" Spacing=\"" +
          shortest(g.spacing) + "\" Direction=\"" + shortest(rows.col(0)) + " " + shortest(rows.col(1)) +
          " " + shortest(rows.col(2)) + "\">\n";
  text += field_data(volume, warnings);
  text += "    <Piece Extent=\"" + extent +
          "\">\n      <PointData Scalars=\"scalars\">\n        <DataArray type=\"" + type +
          "\" Name=\"scalars\" format=\"appended\" offset=\"0\"/>\n      </PointData>\n    </Piece>\n" +
          "  </ImageData>\n  <AppendedData encoding=\"raw\">\n   _";
  OutputFile out(path);
  out.write(text);
  with_voxel_bytes(volume, [&](const void* data, std::size_t n) {
    if (compress) {
      write_blocks(out, data, n);
    } else {
      const std::uint64_t bytes = n;
      out.write(&bytes, sizeof bytes);
      out.write(data, n);
    }
  });
  out.write("\n  </AppendedData>\n</VTKFile>\n");
  out.commit();
  return warnings;
}

}  // namespace vol::io
