#include "mesh/measures.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "base/compensated_sum.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/vec.h"

namespace vol::mesh {
namespace {

using Index = std::uint32_t;

class UnionFind {
 public:
  explicit UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  Index root(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Index a, Index b) {
    a = root(a);
    b = root(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Index> parent_;
};

/// Triangles of each vertex, one list after the other.
struct Incidence {
  std::vector<std::size_t> first;
  std::vector<Index> triangle;

  explicit Incidence(const TriangleMesh& mesh)
      : first(mesh.positions.size() + 1, 0), triangle(3 * mesh.triangles.size()) {
    for (const auto& t : mesh.triangles) {
      for (const Index v : t) ++first[v + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
      for (const Index v : mesh.triangles[n]) triangle[next[v]++] = static_cast<Index>(n);
    }
  }
};

/// An edge of a triangle at a vertex v, as the way to the other end w: +1 from v to w, -1 from w to v.
struct Spoke {
  Index to;
  int way;
};

struct Counts {
  Topology topology;
  std::vector<std::array<Index, 2>> boundary;
};

/// Do the triangles about a vertex, as edges from one neighbour to another, make one path or one cycle?
bool is_fan(const std::vector<std::array<Index, 2>>& link, const std::vector<Spoke>& spokes) {
  // Each neighbour at most twice: then paths and cycles only, and one if walking from an end meets all.
  for (std::size_t i = 0; i < spokes.size();) {
    std::size_t j = i;
    while (j < spokes.size() && spokes[j].to == spokes[i].to) ++j;
    if (j - i > 2) return false;
    i = j;
  }
  std::vector<bool> seen(link.size(), false);
  std::vector<std::size_t> open{0};
  seen[0] = true;
  std::size_t met = 1;
  while (!open.empty()) {
    const auto at = link[open.back()];
    open.pop_back();
    for (std::size_t n = 0; n < link.size(); ++n) {
      if (seen[n]) continue;
      const auto& other = link[n];
      if (other[0] == at[0] || other[0] == at[1] || other[1] == at[0] || other[1] == at[1]) {
        seen[n] = true;
        ++met;
        open.push_back(n);
      }
    }
  }
  return met == link.size();
}

Counts count_vertices(const TriangleMesh& mesh, const Incidence& incidence, std::int64_t begin,
                      std::int64_t end) {
  Counts counts;
  Topology& t = counts.topology;
  std::vector<Spoke> spokes;
  std::vector<std::array<Index, 2>> link;
  for (std::int64_t n = begin; n < end; ++n) {
    const auto v = static_cast<Index>(n);
    if (incidence.first[v] == incidence.first[v + 1]) continue;
    ++t.vertices;
    spokes.clear();
    link.clear();
    for (std::size_t i = incidence.first[v]; i < incidence.first[v + 1]; ++i) {
      const auto& corner = mesh.triangles[incidence.triangle[i]];
      const int at = corner[0] == v ? 0 : corner[1] == v ? 1 : 2;
      const Index next = corner[(at + 1) % 3];
      const Index previous = corner[(at + 2) % 3];
      spokes.push_back({next, 1});
      spokes.push_back({previous, -1});
      link.push_back({next, previous});
    }
    std::sort(spokes.begin(), spokes.end(), [](const Spoke& a, const Spoke& b) { return a.to < b.to; });
    if (!is_fan(link, spokes)) ++t.non_manifold_vertices;
    for (std::size_t i = 0; i < spokes.size();) {
      std::size_t j = i;
      int ways = 0;
      for (; j < spokes.size() && spokes[j].to == spokes[i].to; ++j) ways += spokes[j].way;
      if (v < spokes[i].to) {  // each edge once
        ++t.edges;
        if (j - i == 1) {
          ++t.boundary_edges;
          counts.boundary.push_back({v, spokes[i].to});
        } else if (j - i > 2) {
          ++t.non_manifold_edges;
        } else if (ways != 0) {
          ++t.misoriented_edges;
        }
      }
      i = j;
    }
  }
  return counts;
}

void add(Counts& total, const Counts& part) {
  Topology& t = total.topology;
  const Topology& p = part.topology;
  t.vertices += p.vertices;
  t.edges += p.edges;
  t.boundary_edges += p.boundary_edges;
  t.non_manifold_edges += p.non_manifold_edges;
  t.misoriented_edges += p.misoriented_edges;
  t.non_manifold_vertices += p.non_manifold_vertices;
  total.boundary.insert(total.boundary.end(), part.boundary.begin(), part.boundary.end());
}

std::int64_t components_of(const std::vector<std::array<Index, 2>>& edges, std::size_t vertices) {
  UnionFind sets(vertices);
  for (const auto& e : edges) sets.join(e[0], e[1]);
  std::vector<Index> roots;
  for (const auto& e : edges) roots.push_back(sets.root(e[0]));
  std::sort(roots.begin(), roots.end());
  return std::unique(roots.begin(), roots.end()) - roots.begin();
}

}  // namespace

Topology topology(const TriangleMesh& mesh) {
  if (mesh.triangles.size() > std::numeric_limits<Index>::max()) {
    throw Error("the mesh has " + std::to_string(mesh.triangles.size()) +
                " triangles, and over 2^32 - 1 are not counted: take a part of the volume, or --no-measures");
  }
  const Incidence incidence(mesh);
  const auto vertices = static_cast<std::int64_t>(mesh.positions.size());
  Counts counts = parallel_reduce<Counts>(
      0, vertices, 1 << 14,
      [&](std::int64_t begin, std::int64_t end) { return count_vertices(mesh, incidence, begin, end); }, add);
  Topology result = counts.topology;
  result.triangles = static_cast<std::int64_t>(mesh.triangles.size());
  result.euler = result.vertices - result.edges + result.triangles;
  if (!counts.boundary.empty()) result.boundary_loops = components_of(counts.boundary, mesh.positions.size());
  UnionFind sets(mesh.positions.size());
  for (const auto& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  for (std::int64_t v = 0; v < vertices; ++v) {
    const auto n = static_cast<Index>(v);
    result.components += incidence.first[n] != incidence.first[n + 1] && sets.root(n) == n;
  }
  return result;
}

Extent extent(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return {};
  const auto position = [&](Index v) { return Eigen::Map<const Vec3>(mesh.positions[v].data()); };
  const Vec3 origin = position(mesh.triangles[0][0]);
  struct Sums {
    CompensatedSum area, volume;
  };
  const auto sums = parallel_reduce<Sums>(
      0, static_cast<std::int64_t>(mesh.triangles.size()), 1 << 14,
      [&](std::int64_t begin, std::int64_t end) {
        Sums part;
        for (std::int64_t n = begin; n < end; ++n) {
          const auto& t = mesh.triangles[static_cast<std::size_t>(n)];
          const Vec3 a = position(t[0]) - origin;
          const Vec3 normal = (position(t[1]) - position(t[0])).cross(position(t[2]) - position(t[0]));
          part.area.add(0.5 * normal.stableNorm());
          part.volume.add(a.dot(normal) / 6);
        }
        return part;
      },
      [](Sums& total, const Sums& part) {
        total.area.add(part.area);
        total.volume.add(part.volume);
      });
  return {sums.area.value(), sums.volume.value()};
}

}  // namespace vol::mesh
