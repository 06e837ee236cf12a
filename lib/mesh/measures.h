#pragma once
#include <cstdint>

#include "mesh/triangle_mesh.h"

namespace vol::mesh {

/// What a mesh is as a complex: each vertex number is a vertex, whatever its position.
struct Topology {
  std::int64_t vertices = 0;  ///< that a triangle uses
  std::int64_t edges = 0;
  std::int64_t triangles = 0;
  std::int64_t components = 0;             ///< of triangles connected by vertices
  std::int64_t euler = 0;                  ///< vertices - edges + triangles
  std::int64_t boundary_edges = 0;         ///< of one triangle
  std::int64_t boundary_loops = 0;         ///< components of the boundary edges
  std::int64_t non_manifold_edges = 0;     ///< of more than two triangles
  std::int64_t misoriented_edges = 0;      ///< of two triangles that run along it the same way
  std::int64_t non_manifold_vertices = 0;  ///< whose triangles are not one fan

  [[nodiscard]] bool is_manifold() const {
    return non_manifold_edges == 0 && misoriented_edges == 0 && non_manifold_vertices == 0;
  }
};
/// \throws vol::Error on 2^32 triangles or more
[[nodiscard]] Topology topology(const TriangleMesh& mesh);

/// Sum of the triangles' areas, and the volume they enclose: a sixth of the sum of a . (b x c), relative to a
/// vertex of the mesh; positive where normals point outward, without meaning where the mesh is not closed.
struct Extent {
  double area = 0;
  double volume = 0;
};
[[nodiscard]] Extent extent(const TriangleMesh& mesh);

}  // namespace vol::mesh
