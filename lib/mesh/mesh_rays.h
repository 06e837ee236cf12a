#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/vec.h"
#include "mesh/triangle_mesh.h"

namespace vol::mesh {

/// Where rays meet the triangles of a mesh, by a tree of boxes (split at the median of the longest axis).
/// Only vertices that triangles have play a part, and each box is as wide as its own corners' rounding asks.
///
/// Of two triangles that share an edge, a ray through the edge meets exactly one, or, at an outline, both or
/// none: the triangle is seen along the ray, in coordinates sheared so that the ray is the origin (Woop,
/// Benthin and Wald 2013), the sign of each edge's determinant is exact, and where it is 0 the ray is taken
/// to pass infinitesimally beside the edge, for all triangles on the same side. So a closed mesh has no holes
/// and is left as often as it is entered. Triangles of no area, or seen edge-on, are not met.
///
/// Refers to the mesh, which must live longer.
class MeshRays {
 public:
  /// \throws vol::Error on a triangle whose vertex does not exist, a position that is not finite, and normals
  /// for some of the vertices alone
  explicit MeshRays(const TriangleMesh& mesh);

  struct Hit {
    double t;  ///< along the ray, in lengths of its direction
    std::uint32_t triangle;
    std::array<double, 3> weight;  ///< of its corners: at least 0, sum 1
  };

  /// Calls f for every hit with t in [from, to], in no order; f returns a new `to`, at most the old one.
  /// \param direction  finite, not 0
  void for_hits(const Vec3& origin, const Vec3& direction, double from, double to,
                const std::function<double(const Hit&)>& f) const;

  /// How many triangles a whole line is tried against: its cost, at least its hits.
  [[nodiscard]] std::int64_t tried(const Vec3& origin, const Vec3& direction) const;

  /// Unit normal at a hit: the vertices' normals, interpolated, or where there are none the triangle's.
  [[nodiscard]] Vec3 normal(const Hit& hit) const;

  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }

 private:
  struct Node {
    double low[3];  ///< of the box, and below it what shearing may round its corners by
    double high[3];
    std::uint32_t first = 0;  ///< of a leaf: its first triangle in order_; else its second child
    std::uint32_t count = 0;  ///< triangles of a leaf; 0: not one, and the first child is the next node
  };
  std::uint32_t build(std::uint32_t begin, std::uint32_t end, std::vector<double>& middles);
  /// f of every triangle whose box the ray passes within [from, to]; it may change `to`.
  template <class F>
  void for_candidates(const Vec3& origin, const Vec3& direction, const double& from, const double& to,
                      const F& f) const;

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace vol::mesh
