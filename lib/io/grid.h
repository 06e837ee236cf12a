#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "curvilinear/grid.h"
#include "io/file.h"
#include "io/volume.h"

namespace vol::io {

/// What is known of a PLOT3D file; what is not is told from its bytes.
struct Plot3dLayout {
  std::optional<bool> ascii, big_endian, records, multi_block, iblank;
  std::optional<int> bits;  ///< of a real number: 32 or 64

  /// "auto", or words joined by commas: ascii | big | little, records (Fortran's, a length before and after
  /// each) | stream, single | multi, f32 | f64, iblank | plain. Throws vol::Error on other words.
  [[nodiscard]] static Plot3dLayout parse(const std::string& text);
};

struct GridOptions {
  std::filesystem::path solution;  ///< PLOT3D's q file; empty: positions alone
  Plot3dLayout plot3d;
  std::int64_t memory_limit = ReadOptions::physical_memory();  ///< bytes a file may take
};

/// Whether the first bytes are those of a VTK XML structured grid.
[[nodiscard]] bool is_vts(InputFile& file);

/// Reads a curvilinear grid: VTK XML structured grid (.vts: all point arrays, of vectors the components
/// NAME.x .. NAME.z; hidden points by vtkGhostType; cell arrays are not read) or PLOT3D. A PLOT3D file says
/// nothing of its own layout: all are tried, and the one that uses the file up to its last byte is it; where
/// none does, one that leaves zeros over, less than a variable of them (some programs append such padding). A
/// solution gives the arrays density, momentum.x .. z and energy, and its mach, alpha, re and time the
/// attributes plot3d.mach ...
///
/// Memory taken grows with the file. Throws vol::Error, one line: no layout fits, or several do (with what
/// was tried); 2-D grids; a solution of other sizes than the grid's; whatever curvilinear::require_valid()
/// refuses.
[[nodiscard]] curvilinear::Grid read_grid(const std::filesystem::path& path, const GridOptions& options = {});

/// Writes a grid of one block as VTK XML structured grid, in double precision; "-" is standard output.
/// \returns what could not be held, one sentence each \throws vol::Error for several blocks, other extensions
std::vector<std::string> write_grid(const std::filesystem::path& path, const curvilinear::Grid& grid);

/// Throws what write_grid() would throw for the path alone.
void require_grid_output(const std::filesystem::path& path);

}  // namespace vol::io
