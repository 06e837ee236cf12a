#pragma once
#include "io/grid.h"

// Private to lib/io: one reader a format of curvilinear grids.
namespace vol::io {

[[nodiscard]] curvilinear::Grid read_vts(InputFile& file, std::int64_t memory_limit);
[[nodiscard]] curvilinear::Grid read_plot3d(InputFile& file, const GridOptions& options);

}  // namespace vol::io
