#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cli/record.h"
#include "curvilinear/grid.h"
#include "io/file.h"

// How tools are told which curvilinear grid to read. Target vol_cli_grid.
namespace vol::cli {

struct GridInput {
  std::filesystem::path path;      ///< .vts or PLOT3D
  std::filesystem::path solution;  ///< --solution
  std::string plot3d;              ///< --plot3d; empty: auto
  std::string variable;            ///< --variable; empty: the first array
  std::string region;              ///< --region; empty: all
};

/// Declares --solution, --plot3d, --variable and --region.
void add_grid_options(CLI::App& app, GridInput& input);

/// Reads the grid, or its region (phase "read") and notes its files among the record's inputs.
[[nodiscard]] curvilinear::Grid load(const GridInput& input, Record& record);

/// A scalar of every point of every block.
struct GridVariable {
  std::string name;
  std::vector<std::vector<double>> values;
  double low = 0, high = 0;  ///< of all blocks
};
/// --variable of the grid, or its first array (phase "variable"). Errors name the file that lacks what it
/// needs.
[[nodiscard]] GridVariable variable(const GridInput& input, const curvilinear::Grid& grid, Record& record);

/// Whether a file is asked for as a grid: .vts by its bytes; PLOT3D, which has no magic bytes, by its
/// extension or by an option that only it has.
[[nodiscard]] bool is_grid(const GridInput& input, io::InputFile& file);

/// What vol-info says of a grid: bounds, sizes, quality of each block, arrays, and the range of --variable
/// where one is named.
[[nodiscard]] nlohmann::ordered_json describe(const GridInput& input, const curvilinear::Grid& grid,
                                              Record& record);

}  // namespace vol::cli
