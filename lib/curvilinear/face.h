#pragma once
#include <array>
#include <cstdint>

#include "curvilinear/solid.h"

namespace vol::curvilinear {

/// A face between two cells of a block, or at its border: on points number at[axis] along `axis`, cell
/// number at[a] along the other two axes. Its parameters u and v run along the axes after `axis`, in turn
/// (y z, z x, x y), so that du x dv points to where `axis` grows in a right-handed grid.
struct Face {
  std::array<std::int32_t, 3> at{};
  std::uint32_t axis : 2 = 0;
  std::uint32_t block : 30 = 0;
};

/// Control points of a face: [r + 4 s], r along u, s along v.
using FacePatch = std::array<Vec3, 16>;

/// The face of the solids on both of its sides, to the bit, without the solids.
[[nodiscard]] FacePatch face_patch(const Block& block, const Face& face, CellKind kind, double beta);

/// Parameters of the solid beyond the face (where `axis` grows) at (u, v) of the face; with `before` of the
/// solid on the other side.
[[nodiscard]] Vec3 cell_parameters(const Face& face, bool before, double u, double v);

/// The sign that the Jacobian dx/d(i, j, k) has in most of the block: of its volume, by the centres of the
/// trilinear cells. -1 or 1.
[[nodiscard]] int handedness(const Block& block);

}  // namespace vol::curvilinear
