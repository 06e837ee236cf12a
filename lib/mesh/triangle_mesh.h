#pragma once
#include <array>
#include <cstdint>

#include "base/buffer.h"

namespace vol::mesh {

/// Triangles over shared vertices, in world coordinates. Corners are in counterclockwise order as seen from
/// the side that the normals point to.
struct TriangleMesh {
  Buffer<std::array<double, 3>> positions;
  Buffer<std::array<float, 3>> normals;  ///< unit, one a vertex, (0,0,0) where there is none; or empty
  Buffer<std::array<std::uint32_t, 3>> triangles;
};

/// Appends another mesh; both have normals or neither. \throws vol::Error on more than 2^32 - 1 vertices
void append(TriangleMesh& mesh, const TriangleMesh& other);

}  // namespace vol::mesh
