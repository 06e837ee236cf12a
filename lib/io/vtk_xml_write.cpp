#include <algorithm>

#include "base/error.h"
#include "io/vtk_xml.h"

namespace vol::io {
namespace {

constexpr std::size_t kBlock = 1 << 20;  // bytes a zlib block holds before compression

/// A string array of one value: the numbers of its bytes, then 0.
std::string string_array(const std::string& key, const std::string& value) {
  std::string text = "      <Array type=\"String\" Name=\"" + xml_escaped(key) +
                     "\" NumberOfTuples=\"1\" format=\"ascii\">\n       ";
  for (const char c : value) text += " " + std::to_string(static_cast<int>(static_cast<unsigned char>(c)));
  return text + " 0\n      </Array>\n";
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

std::string_view vtk_type_name(volume::VoxelType type) {
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

std::string vtk_file_start(const char* data_set, bool compress) {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + std::string(data_set) +
                     "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"";
  if (compress) text += " compressor=\"vtkZLibDataCompressor\"";
  return text + ">\n";
}

std::string vtk_field_data(const std::map<std::string, std::string>& attributes, const char* format,
                           std::vector<std::string>& warnings) {
  std::string text;
  for (const auto& [key, value] : attributes) {
    const bool holdable = !key.empty() && value.find('\0') == std::string::npos &&
                          std::all_of(key.begin(), key.end(), [](char c) { return c >= ' ' || c == '\n'; });
    if (holdable) {
      text += string_array(key, value);
    } else {
      warnings.push_back(std::string(format) + " cannot hold the attribute " + in_quotes(key) +
                         "; it is left out");
    }
  }
  return text.empty() ? text : "    <FieldData>\n" + text + "    </FieldData>\n";
}

void write_vtk_data(OutputFile& out, const void* data, std::size_t n, bool compress) {
  if (compress) {
    write_blocks(out, data, n);
  } else {
    const std::uint64_t bytes = n;
    out.write(&bytes, sizeof bytes);
    out.write(data, n);
  }
}

}  // namespace vol::io
