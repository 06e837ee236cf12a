#pragma once
#include "mesh/triangle_mesh.h"

namespace vol::mesh {

/// What weld() changed.
struct WeldCounts {
  std::int64_t vertices_merged = 0;
  std::int64_t triangles_dropped = 0;  ///< that had two corners in one place
  std::int64_t vertices_unused = 0;    ///< dropped because no triangle was left that used them
  std::int64_t flat_triangles = 0;     ///< kept: three places in a line; to drop one would tear the mesh
};

/// Makes one vertex of all that are at the same place, bit by bit (0 and -0 alike), and drops the triangles
/// without area that this leaves. The point set stays what it was, and no edge opens: a triangle is dropped
/// only with an edge of length 0, between neighbours that then meet. Sheets that are at one place touch
/// afterwards, so that a manifold may become none. The first vertex of a place stays, with its normal: where
/// the normals differ, at a crease of a closed border, the one side's. Order is kept.
WeldCounts weld(TriangleMesh& mesh);

/// Rounds positions to float, as files hold them.
///
/// \param finest  the smallest spacing of the grid that the mesh is of
/// \throws vol::Error where a position is beyond float's range, and where floats are further apart than a
/// thousandth of `finest` at the largest coordinate: rounding would move vertices as far, and merge sheets
void round_to_float(TriangleMesh& mesh, double finest);

/// \throws vol::Error on a position that is not finite
void require_finite(const TriangleMesh& mesh);

}  // namespace vol::mesh
