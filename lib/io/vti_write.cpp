#include "io/header_text.h"
#include "io/volume_formats.h"
#include "io/vtk_xml.h"

namespace vol::io {

Warnings write_vti(const std::filesystem::path& path, const volume::Volume& volume, bool compress) {
  Warnings warnings;
  const volume::GridGeometry& g = volume.geometry();
  const std::string extent = "0 " + std::to_string(g.dims[0] - 1) + " 0 " + std::to_string(g.dims[1] - 1) +
                             " 0 " + std::to_string(g.dims[2] - 1);
  const Mat3 rows = g.direction.transpose();  // VTK writes the matrix by rows
  const std::string type(vtk_type_name(volume.voxel_type()));
  auto attributes = volume.attributes;
  if (g.space != volume::Space::none) attributes["precis.space"] = std::string(volume::name(g.space));
  std::string text = vtk_file_start("ImageData", compress);
  text += "  <ImageData WholeExtent=\"" + extent + "\" Origin=\"" + shortest(g.origin) + "\" Spacing=\"" +
          shortest(g.spacing) + "\" Direction=\"" + shortest(rows.col(0)) + " " + shortest(rows.col(1)) +
          " " + shortest(rows.col(2)) + "\">\n";
  text += vtk_field_data(attributes, "VTI", warnings);
  text += "    <Piece Extent=\"" + extent +
          "\">\n      <PointData Scalars=\"scalars\">\n        <DataArray type=\"" + type +
          "\" Name=\"scalars\" format=\"appended\" offset=\"0\"/>\n      </PointData>\n    </Piece>\n" +
          "  </ImageData>\n  <AppendedData encoding=\"raw\">\n   _";
  OutputFile out(path);
  out.write(text);
  with_voxel_bytes(volume, [&](const void* data, std::size_t n) { write_vtk_data(out, data, n, compress); });
  out.write("\n  </AppendedData>\n</VTKFile>\n");
  out.commit();
  return warnings;
}

}  // namespace vol::io
