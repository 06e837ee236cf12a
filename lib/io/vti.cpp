// VTK XML image data.
#include "base/error.h"
#include "io/volume_formats.h"
#include "io/vtk_xml.h"

namespace vol::io {
namespace {

bool on_cells(const VtkArray& array) {
  return array.on == VtkArray::On::cells;
}

bool is_scalar(const VtkArray& array) {
  const std::string components = array.tag["NumberOfComponents"];
  return components.empty() || components == "1";
}

/// The array asked for; else the active scalars, else the first scalar array, of points before cells.
const VtkArray& choose_array(const VtkDocument& document, const std::string& wanted) {
  const VtkArray* chosen = nullptr;
  int best = 0;
  std::string names;
  for (const VtkArray& array : document.arrays) {
    const std::string name = array.tag["Name"];
    names += (names.empty() ? "" : ", ") + in_quotes(name) +
             (is_scalar(array) ? "" : " (" + array.tag["NumberOfComponents"] + " components)");
    int rank = 0;
    if (!wanted.empty()) {
      rank = name != wanted ? 0 : on_cells(array) ? 1 : 2;
    } else if (is_scalar(array)) {
      const std::string& active = document.active[on_cells(array) ? 1 : 0];
      rank = (on_cells(array) ? 1 : 3) + (!active.empty() && active == name ? 1 : 0);
    }
    if (rank > best) {
      best = rank;
      chosen = &array;
    }
  }
  if (chosen == nullptr) {
    throw Error(document.name + ": has no " +
                (wanted.empty() ? "scalar array" : "array " + in_quotes(wanted)) +
                (names.empty() ? "; there is none at all" : "; there are " + names));
  }
  if (!is_scalar(*chosen)) {
    throw Error(document.name + ": array " + in_quotes(chosen->tag["Name"]) + " has " +
                in_quotes(chosen->tag["NumberOfComponents"]) + " components, expected a scalar");
  }
  return *chosen;
}

volume::GridGeometry parse_geometry(const VtkDocument& document, bool on_cells) {
  const auto extent = parse_extent(document);
  volume::GridGeometry geometry;
  if (const auto text = document.data_set["Spacing"]; !text.empty()) {
    geometry.spacing = parse_vector(document.field("Spacing"), text);
  }
  if (const auto text = document.data_set["Origin"]; !text.empty()) {
    geometry.origin = parse_vector(document.field("Origin"), text);
  }
  if (const auto text = document.data_set["Direction"]; !text.empty()) {
    const auto rows = parse_numbers(document.field("Direction"), text, 9);
    for (int i = 0; i < 9; ++i) geometry.direction(i / 3, i % 3) = rows[static_cast<std::size_t>(i)];
  }
  Vec3 first;  // index of the first sample, in points from the image's origin
  for (int a = 0; a < 3; ++a) {
    const std::int64_t low = extent[static_cast<std::size_t>(2 * a)],
                       high = extent[static_cast<std::size_t>(2 * a + 1)];
    const std::int64_t points = high - low + 1;
    const bool shifted = on_cells && points > 1;
    geometry.dims[static_cast<std::size_t>(a)] = shifted ? points - 1 : points;
    first[a] = static_cast<double>(low) + (shifted ? 0.5 : 0.0);
  }
  geometry.origin = geometry.index_to_world(first);
  return geometry;
}

}  // namespace

bool is_vtk_xml(std::string_view start) {
  return start.compare(0, 5, "<?xml") == 0 || start.compare(0, 8, "<VTKFile") == 0;
}

volume::Volume read_vti(InputFile& file, const ReadOptions& options) {
  const std::string text = read_vtk_text(file, options);
  VtkDocument document = parse_vtk_document(display_name(file.path()), text, "ImageData");
  const VtkArray& array = choose_array(document, options.array);
  VoxelLayout layout;
  layout.type = voxel_type(document, array.tag);
  layout.geometry = parse_geometry(document, on_cells(array));
  layout.big_endian = document.big_endian();
  if (const auto space = document.attributes.find("precis.space"); space != document.attributes.end()) {
    layout.geometry.space = space->second == "LPS"   ? volume::Space::lps
                            : space->second == "RAS" ? volume::Space::ras
                                                     : volume::Space::none;
    document.attributes.erase(space);
  }
  FileSource appended(file);
  volume::Volume volume = read_vtk_array(document, array, layout, &appended, options);
  volume.attributes = std::move(document.attributes);
  return volume;
}

}  // namespace vol::io
