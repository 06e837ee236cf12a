#include "mesh/triangle_mesh.h"

#include <limits>

#include "base/error.h"

namespace vol::mesh {

void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const std::size_t before = mesh.positions.size();
  if (before + other.positions.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("the mesh has more than 2^32 - 1 vertices: take a part of the volume");
  }
  if (before != 0 && mesh.normals.empty() != other.normals.empty()) {
    throw Error("a mesh with normals and one without cannot be one");
  }
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  const std::size_t first = mesh.triangles.size();
  mesh.triangles.insert(mesh.triangles.end(), other.triangles.begin(), other.triangles.end());
  for (std::size_t n = first; n < mesh.triangles.size(); ++n) {
    for (auto& v : mesh.triangles[n]) v += static_cast<std::uint32_t>(before);
  }
}

}  // namespace vol::mesh
