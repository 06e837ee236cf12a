#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/header_text.h"
#include "io/voxel_data.h"
#include "io/xml.h"

// Private to lib/io: what VTK's XML files have in common, after "VTK File Formats" (XML formats) and what VTK
// 9 writes; image data (vti.cpp) and structured grids (vts.cpp) are told by the name of their element.
namespace vol::io {

/// One <DataArray> of the piece.
struct VtkArray {
  XmlTag tag;
  enum class On { points, cells, positions } on = On::points;
  std::string_view inline_data;
};

struct VtkDocument {
  std::string name;  ///< of the file
  XmlTag file, data_set, piece;
  std::string active[2];  ///< the Scalars of PointData, of CellData
  std::vector<VtkArray> arrays;
  std::map<std::string, std::string> attributes;  ///< string arrays of <FieldData>
  std::string appended;                           ///< encoding of <AppendedData>, "" without one

  [[nodiscard]] Field field(std::string_view which) const { return {name, which}; }
  [[nodiscard]] bool big_endian() const;
};

/// All text up to the underscore after which appended data begin, or up to the end of the file.
[[nodiscard]] std::string read_vtk_text(InputFile& file, const ReadOptions& options);

/// Refers to the text. \param data_set "ImageData" or "StructuredGrid"; one piece
[[nodiscard]] VtkDocument parse_vtk_document(const std::string& name, std::string_view text,
                                             const std::string& data_set);

[[nodiscard]] volume::VoxelType voxel_type(const VtkDocument& document, const XmlTag& array);

/// First and last point of each axis: the piece's Extent.
[[nodiscard]] std::vector<std::int64_t> parse_extent(const VtkDocument& document);

/// The array's numbers, as many as the layout has samples. \param appended what comes after the underscore,
/// where the array's own begin
[[nodiscard]] volume::Volume read_vtk_array(const VtkDocument& document, const VtkArray& array,
                                            const VoxelLayout& layout, ByteSource* appended,
                                            const ReadOptions& options);

// Writing.
[[nodiscard]] std::string_view vtk_type_name(volume::VoxelType type);
/// The first line and the opening tag of VTKFile.
[[nodiscard]] std::string vtk_file_start(const char* data_set, bool compress);
/// Attributes as string arrays of <FieldData>; those it cannot hold become warnings.
[[nodiscard]] std::string vtk_field_data(const std::map<std::string, std::string>& attributes,
                                         const char* format, std::vector<std::string>& warnings);
/// One array of the appended data, as vtkZLibDataCompressor has it or plain.
void write_vtk_data(OutputFile& out, const void* data, std::size_t n, bool compress);

}  // namespace vol::io
