#include "cli/grid_input.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/naming.h"
#include "cli/options.h"
#include "curvilinear/flow.h"
#include "curvilinear/quality.h"
#include "io/grid.h"

namespace vol::cli {

void add_grid_options(CLI::App& app, GridInput& input) {
  const char* group = "Curvilinear grid";
  app.add_option("--solution", input.solution, "PLOT3D's q file: density, momentum, energy")
      ->type_name("FILE")
      ->group(group);
  app.add_option(
         "--plot3d", input.plot3d,
         "How a PLOT3D file lies, by words joined by commas: ascii, big or little, records or stream, "
         "single or multi, f32 or f64, iblank or plain; auto tries all [auto]")
      ->type_name("LAYOUT")
      ->group(group);
  app.add_option(
         "--variable", input.variable,
         "An array of the grid, or of a solution momentum-magnitude, velocity.x .. z, "
         "velocity-magnitude, pressure, temperature, mach, entropy, vorticity-magnitude [the first array]")
      ->type_name("NAME")
      ->group(group);
  app.add_option("--region", input.region,
                 "Of a grid of one block these cells alone: x0,y0,z0:x1,y1,z1, half open")
      ->group(group);
}

curvilinear::Grid load(const GridInput& input, Record& record) {
  io::GridOptions options;
  options.solution = input.solution;
  options.plot3d = io::Plot3dLayout::parse(input.plot3d.empty() ? "auto" : input.plot3d);
  std::optional<Region> region;
  if (!input.region.empty()) region = parse_region("--region", input.region);
  record.input(input.path);
  if (!input.solution.empty()) record.input(input.solution);
  auto grid = record.timed("read", [&] { return io::read_grid(input.path, options); });
  if (region) {
    naming(input.path, [&] {
      if (grid.blocks.size() != 1)
        throw Error("--region is for grids of one block, not of " + std::to_string(grid.blocks.size()));
      grid.blocks[0] = curvilinear::cropped(grid.blocks[0], region->lower, region->upper);
    });
  }
  return grid;
}

GridVariable variable(const GridInput& input, const curvilinear::Grid& grid, Record& record) {
  return record.timed("variable", [&] {
    return naming(input.solution.empty() ? input.path : input.solution, [&] {
      GridVariable v;
      v.name = input.variable.empty() ? std::string(curvilinear::default_variable(grid)) : input.variable;
      v.values = curvilinear::make_variable(grid, v.name);
      v.low = std::numeric_limits<double>::infinity();
      v.high = -v.low;
      for (const auto& block : v.values) {
        const auto [low, high] = std::minmax_element(block.begin(), block.end());
        v.low = std::min(v.low, *low);
        v.high = std::max(v.high, *high);
      }
      return v;
    });
  });
}

bool is_grid(const GridInput& input, io::InputFile& file) {
  return io::is_vts(file) || !input.plot3d.empty() || !input.solution.empty() ||
         input.path.extension() == ".xyz";
}

nlohmann::ordered_json describe(const GridInput& input, const curvilinear::Grid& grid, Record& record) {
  nlohmann::ordered_json info;
  const Box3 bounds = grid.bounds();
  info["bounds_min"] = {bounds.min[0], bounds.min[1], bounds.min[2]};
  info["bounds_max"] = {bounds.max[0], bounds.max[1], bounds.max[2]};
  info["points"] = grid.point_count();
  info["cells"] = grid.cell_count();
  record.count("cells", grid.cell_count());
  record.timed("figures", [&] {
    for (const auto& block : grid.blocks) {
      const auto q = curvilinear::quality(block);
      info["blocks"].push_back({{"dims", block.dims},
                                {"jacobian_min", q.jacobian_min},
                                {"jacobian_max", q.jacobian_max},
                                {"volume", q.volume},
                                {"inverted_cells", q.inverted},
                                {"collapsed_cells", q.collapsed},
                                {"folded_cells", q.folded},
                                {"missing_cells", q.missing}});
    }
  });
  for (const auto& array : grid.blocks[0].arrays) info["arrays"].push_back(array.name);
  if (!input.variable.empty()) {
    const GridVariable v = variable(input, grid, record);
    info["variable"] = v.name;
    info["min"] = v.low;
    info["max"] = v.high;
  }
  info["attributes"] = grid.attributes;
  return info;
}

}  // namespace vol::cli
