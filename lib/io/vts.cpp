// VTK XML structured grids.
#include <cstring>

#include "base/checked.h"
#include "base/error.h"
#include "io/grid_formats.h"
#include "io/header_text.h"
#include "io/vtk_xml.h"

namespace vol::io {
namespace {

constexpr const char* kGhostName = "vtkGhostType";  // bits of vtkDataSetAttributes
constexpr int kHiddenPoint = 2;

std::int64_t components(const VtkDocument& document, const VtkArray& array) {
  const std::string text = array.tag["NumberOfComponents"];
  if (text.empty()) return 1;
  const std::int64_t n = parse_integer(document.field("NumberOfComponents"), text);
  if (n < 1 || n > 1000) document.field("NumberOfComponents").refuse(text, "1 to 1000");
  return n;
}

class Arrays {
 public:
  Arrays(const VtkDocument& document, std::string_view appended, const Dims& dims, std::int64_t memory_limit)
      : document_(document), appended_(appended), dims_(dims) {
    options_.memory_limit = memory_limit;
  }
  /// All numbers of an array, a point's components side by side.
  [[nodiscard]] std::vector<double> numbers(const VtkArray& array) const {
    VoxelLayout layout;
    layout.type = voxel_type(document_, array.tag);
    layout.big_endian = document_.big_endian();
    layout.geometry.dims = {checked_product(dims_[0], components(document_, array)), dims_[1], dims_[2]};
    MemorySource source(document_.name, appended_);
    const volume::Volume volume = read_vtk_array(document_, array, layout, &source, options_);
    return volume::visit(volume, [](const auto& grid) {
      std::vector<double> values;
      values.reserve(grid.voxels.size());
      for (const auto x : grid.voxels) values.push_back(static_cast<double>(x));
      return values;
    });
  }

 private:
  const VtkDocument& document_;
  std::string_view appended_;
  Dims dims_;
  ReadOptions options_;
};

void add_arrays(const std::string& name, std::int64_t n, const std::vector<double>& numbers,
                curvilinear::Block& block) {
  static constexpr const char* kAxes[3] = {".x", ".y", ".z"};
  for (std::int64_t c = 0; c < n; ++c) {
    curvilinear::PointArray array;
    array.name = name + (n == 1 ? "" : n == 3 ? kAxes[c] : "." + std::to_string(c));
    for (auto at = static_cast<std::size_t>(c); at < numbers.size(); at += static_cast<std::size_t>(n)) {
      array.values.push_back(numbers[at]);
    }
    block.arrays.push_back(std::move(array));
  }
}

std::string data_array(const std::string& type, const std::string& name, int n, std::size_t offset) {
  return "        <DataArray type=\"" + type + "\" Name=\"" + xml_escaped(name) + "\" NumberOfComponents=\"" +
         std::to_string(n) + "\" format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
}

}  // namespace

curvilinear::Grid read_vts(InputFile& file, std::int64_t memory_limit) {
  ReadOptions options;
  options.memory_limit = memory_limit;
  const std::string name = display_name(file.path());
  const std::string text = read_vtk_text(file, options);
  VtkDocument document = parse_vtk_document(name, text, "StructuredGrid");
  const auto rest = file.read_rest(memory_limit);
  const auto extent = parse_extent(document);
  curvilinear::Grid grid;
  curvilinear::Block& block = grid.blocks.emplace_back();
  for (std::size_t a = 0; a < 3; ++a) block.dims[a] = extent[2 * a + 1] - extent[2 * a] + 1;
  (void)checked_count(block.dims);
  const Arrays arrays(document, {reinterpret_cast<const char*>(rest.data()), rest.size()}, block.dims,
                      memory_limit);
  for (const VtkArray& array : document.arrays) {
    const std::int64_t n = components(document, array);
    if (array.on == VtkArray::On::positions) {
      if (n != 3) throw Error(name + ": positions have " + std::to_string(n) + " components, expected 3");
      const auto numbers = arrays.numbers(array);
      block.points.clear();
      for (std::size_t at = 0; at + 2 < numbers.size(); at += 3) {
        block.points.emplace_back(numbers[at], numbers[at + 1], numbers[at + 2]);
      }
    } else if (array.on == VtkArray::On::points && array.tag["Name"] == kGhostName && n == 1) {
      block.hidden.clear();
      for (const double x : arrays.numbers(array)) {
        const bool byte = x >= 0 && x < 256;  // what else stands there is no set of bits
        block.hidden.push_back(byte && (static_cast<int>(x) & kHiddenPoint) != 0 ? 1 : 0);
      }
    } else if (array.on == VtkArray::On::points) {
      add_arrays(array.tag["Name"], n, arrays.numbers(array), block);
    }
  }
  if (block.points.empty()) throw Error(name + ": structured grid without positions (Points)");
  grid.attributes = std::move(document.attributes);
  return grid;
}

std::vector<std::string> write_grid(const std::filesystem::path& path, const curvilinear::Grid& grid) {
  require_grid_output(path);
  if (grid.blocks.size() != 1) {
    throw Error(output_name(path) + ": a .vts file holds one block, the grid has " +
                std::to_string(grid.blocks.size()));
  }
  const curvilinear::Block& block = grid.blocks[0];
  std::vector<std::string> warnings;
  std::string extent;
  for (const auto n : block.dims) extent += (extent.empty() ? "0 " : " 0 ") + std::to_string(n - 1);
  constexpr std::size_t kLength = sizeof(std::uint64_t);  // before the bytes of each array
  const std::size_t scalar_bytes = kLength + block.points.size() * sizeof(double);
  std::string text = vtk_file_start("StructuredGrid", false) + "  <StructuredGrid WholeExtent=\"" + extent +
                     "\">\n" + vtk_field_data(grid.attributes, "VTS", warnings) + "    <Piece Extent=\"" +
                     extent + "\">\n      <PointData" +
                     (block.arrays.empty() ? "" : " Scalars=\"" + xml_escaped(block.arrays[0].name) + "\"") +
                     ">\n";
  std::size_t offset = 0;
  for (const auto& array : block.arrays) {
    text += data_array("Float64", array.name, 1, offset);
    offset += scalar_bytes;
  }
  if (!block.hidden.empty()) {
    text += data_array("UInt8", kGhostName, 1, offset);
    offset += kLength + block.hidden.size();
  }
  text += "      </PointData>\n      <Points>\n" + data_array("Float64", "Points", 3, offset) +
          "      </Points>\n    </Piece>\n  </StructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _";
  OutputFile out(path);
  out.write(text);
  for (const auto& array : block.arrays) {
    write_vtk_data(out, array.values.data(), array.values.size() * sizeof(double), false);
  }
  if (!block.hidden.empty()) {
    std::vector<std::uint8_t> ghosts;
    for (const auto hidden : block.hidden) ghosts.push_back(hidden != 0 ? kHiddenPoint : 0);
    write_vtk_data(out, ghosts.data(), ghosts.size(), false);
  }
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  write_vtk_data(out, block.points.data(), block.points.size() * sizeof(Vec3), false);
  out.write("\n  </AppendedData>\n</VTKFile>\n");
  out.commit();
  return warnings;
}

}  // namespace vol::io
