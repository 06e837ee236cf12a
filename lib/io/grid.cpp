#include "io/grid.h"

#include "base/error.h"
#include "io/grid_formats.h"
#include "io/header_text.h"
#include "io/volume_formats.h"

namespace vol::io {

bool is_vts(InputFile& file) {
  const std::string_view start = file.peek(4096);
  return is_vtk_xml(start) && start.find("\"StructuredGrid\"") != std::string_view::npos;
}

curvilinear::Grid read_grid(const std::filesystem::path& path, const GridOptions& options) {
  InputFile file(path);
  const std::string name = display_name(path);
  const std::string_view start = file.peek(8);
  if (start.empty()) throw Error(name + ": is empty, expected a curvilinear grid");
  const bool vts = is_vts(file);
  if (!vts && is_vtk_xml(start)) throw Error(name + ": VTK XML, but no structured grid (.vts)");
  if (!vts && start[0] == '{') {
    throw Error(name +
                ": a ParaView meta file; give the .xyz file that it names, and its .q file as --solution");
  }
  if (vts && !options.solution.empty()) {
    throw Error(name + ": a .vts grid has its own arrays; --solution goes with PLOT3D");
  }
  curvilinear::Grid grid = vts ? read_vts(file, options.memory_limit) : read_plot3d(file, options);
  try {
    curvilinear::require_valid(grid);
  } catch (const Error& e) {
    throw Error(name, e);
  }
  return grid;
}

void require_grid_output(const std::filesystem::path& path) {
  if (!is_standard_stream(path) && lower_case(path.extension().string()) != ".vts") {
    throw Error(output_name(path) + ": curvilinear grids are written as .vts");
  }
}

}  // namespace vol::io
