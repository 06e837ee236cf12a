#include "mesh/mesh_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "base/error.h"

namespace vol::mesh {
namespace {

constexpr std::uint32_t kLeaf = 4;
// Shearing rounds a position by an ulp or two of its largest coordinate and the origin's: boxes are wider by
// more.
constexpr double kSlack = 16 * std::numeric_limits<double>::epsilon();

/// A point relative to the ray: x and y across it, depth along it.
struct Seen {
  double x, y, depth;
};

/// The ray's frame: the axis of its largest component is depth, the others are sheared along it.
class Shear {
 public:
  Shear(const Vec3& origin, const Vec3& direction) : origin_(origin) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    shear_x_ = direction[x_] / direction[z_];
    shear_y_ = direction[y_] / direction[z_];
    scale_ = 1 / direction[z_];
  }
  [[nodiscard]] Seen operator()(const std::array<double, 3>& p) const {
    const Vec3 q(p[0] - origin_[0], p[1] - origin_[1], p[2] - origin_[2]);
    return {q[x_] - shear_x_ * q[z_], q[y_] - shear_y_ * q[z_], scale_ * q[z_]};
  }

 private:
  Vec3 origin_;
  Eigen::Index x_ = 0, y_ = 0, z_ = 0;
  double shear_x_, shear_y_, scale_;
};

/// a x b, twice the area of the triangle (0, a, b), with its sign right whatever the rounding.
double determinant(const Seen& a, const Seen& b) {
  const double p = a.x * b.y;
  const double q = a.y * b.x;
  const double plain = p - q;
  if (std::abs(plain) > 4 * std::numeric_limits<double>::epsilon() * (std::abs(p) + std::abs(q)))
    return plain;
  // Kahan's difference of products: within 1.5 ulp, and so 0 only where it is (Jeannerod et al. 2013).
  return std::fma(a.x, b.y, -q) - std::fma(a.y, b.x, -q);
}

/// Side of the origin, moved by (e, e^2) for an e as small as you like, of the line from a to b.
bool is_left(double det, const Seen& a, const Seen& b) {
  if (det != 0) return det > 0;
  if (a.y != b.y) return b.y < a.y;
  return b.x > a.x;
}

struct Corners {
  double weight[3];
  double t;
};

/// Where a triangle holds the origin of the ray's frame.
bool meets(const Seen& a, const Seen& b, const Seen& c, Corners& at) {
  const double u = determinant(b, c);
  const double v = determinant(c, a);
  const bool left = is_left(u, b, c);
  if (left != is_left(v, c, a)) return false;
  const double w = determinant(a, b);
  if (left != is_left(w, a, b)) return false;
  const double sum = u + v + w;
  if (sum == 0 || !std::isfinite(sum)) return false;
  at.weight[0] = u / sum;
  at.weight[1] = v / sum;
  at.weight[2] = w / sum;
  at.t = at.weight[0] * a.depth + at.weight[1] * b.depth + at.weight[2] * c.depth;
  return true;
}

}  // namespace

MeshRays::MeshRays(const TriangleMesh& mesh) : mesh_(mesh) {
  const std::size_t vertices = mesh.positions.size();
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw Error("a mesh of over 2^32 - 1 triangles: take a part of it");
  }
  if (!mesh.normals.empty() && mesh.normals.size() != vertices) {
    throw Error("the mesh has " + std::to_string(mesh.normals.size()) + " normals for " +
                std::to_string(vertices) + " vertices");
  }
  for (const auto& p : mesh.positions) {
    for (const double x : p) {
      // Sums and products of three coordinates must be finite too.
      if (!(std::abs(x) < 1e100)) throw Error("the mesh has a position that is not finite, or over 1e100");
    }
  }
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      if (v < vertices) continue;
      throw Error("a triangle of the mesh has vertex " + std::to_string(v) + " of " +
                  std::to_string(vertices));
    }
  }
  order_.resize(mesh.triangles.size());
  std::iota(order_.begin(), order_.end(), 0u);
  if (order_.empty()) return;
  nodes_.reserve(order_.size() / 2 + 1);
  std::vector<double> middles(order_.size());
  (void)build(0, static_cast<std::uint32_t>(order_.size()), middles);
}

/// \param middles  of the triangles, along the axis that is split: made anew by every node
std::uint32_t MeshRays::build(std::uint32_t begin, std::uint32_t end, std::vector<double>& middles) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  std::fill_n(node.low, 3, std::numeric_limits<double>::infinity());
  std::fill_n(node.high, 3, -std::numeric_limits<double>::infinity());
  for (std::uint32_t n = begin; n < end; ++n) {
    for (const std::uint32_t v : mesh_.triangles[order_[n]]) {
      for (std::size_t a = 0; a < 3; ++a) {
        node.low[a] = std::min(node.low[a], mesh_.positions[v][a]);
        node.high[a] = std::max(node.high[a], mesh_.positions[v][a]);
      }
    }
  }
  std::size_t axis = 0;
  double largest = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (node.high[a] - node.low[a] > node.high[axis] - node.low[axis]) axis = a;
    largest = std::max({largest, std::abs(node.low[a]), std::abs(node.high[a])});
  }
  for (std::size_t a = 0; a < 3; ++a) {
    node.low[a] -= kSlack * largest;
    node.high[a] += kSlack * largest;
  }
  if (end - begin <= kLeaf) {
    node.first = begin;
    node.count = end - begin;
    nodes_.push_back(node);
    return number;
  }
  for (std::uint32_t n = begin; n < end; ++n) {
    const auto& t = mesh_.triangles[order_[n]];
    const auto [low, high] =
        std::minmax({mesh_.positions[t[0]][axis], mesh_.positions[t[1]][axis], mesh_.positions[t[2]][axis]});
    middles[order_[n]] = 0.5 * low + 0.5 * high;
  }
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = middles[a];
                     const double y = middles[b];
                     return x != y ? x < y : a < b;  // a total order: the tree is the same everywhere
                   });
  nodes_.push_back(node);
  (void)build(begin, middle, middles);
  const std::uint32_t second = build(middle, end, middles);
  nodes_[number].first = second;
  return number;
}

template <class F>
void MeshRays::for_candidates(const Vec3& origin, const Vec3& direction, const double& from, const double& to,
                              const F& f) const {
  if (nodes_.empty()) return;
  const double slack = kSlack * origin.cwiseAbs().maxCoeff();  // the boxes have their corners' own
  double inverse[3];
  for (int a = 0; a < 3; ++a) inverse[a] = 1 / direction[a];
  const auto passes = [&](const Node& node) {
    double enter = from;
    double leave = to;
    for (int a = 0; a < 3; ++a) {
      const double low = node.low[a] - slack - origin[a];
      const double high = node.high[a] + slack - origin[a];
      if (direction[a] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double t0 = (inverse[a] > 0 ? low : high) * inverse[a];
      const double t1 = (inverse[a] > 0 ? high : low) * inverse[a];
      enter = std::max(enter, t0);
      leave = std::min(leave, t1);
    }
    return enter <= leave;
  };
  std::uint32_t stack[40];  // the tree of 2^32 triangles is 31 deep
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t number = stack[--depth];
    const Node& node = nodes_[number];
    if (!passes(node)) continue;
    if (node.count == 0) {
      stack[depth++] = node.first;
      stack[depth++] = number + 1;
      continue;
    }
    for (std::uint32_t n = node.first; n < node.first + node.count; ++n) f(order_[n]);
  }
}

void MeshRays::for_hits(const Vec3& origin, const Vec3& direction, double from, double to,
                        const std::function<double(const Hit&)>& f) const {
  const Shear shear(origin, direction);
  for_candidates(origin, direction, from, to, [&](std::uint32_t triangle) {
    const auto& corners = mesh_.triangles[triangle];
    Corners at;
    if (!meets(shear(mesh_.positions[corners[0]]), shear(mesh_.positions[corners[1]]),
               shear(mesh_.positions[corners[2]]), at)) {
      return;
    }
    if (at.t >= from && at.t <= to) {
      to = f(Hit{at.t, triangle, {at.weight[0], at.weight[1], at.weight[2]}});
    }
  });
}

std::int64_t MeshRays::tried(const Vec3& origin, const Vec3& direction) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::int64_t count = 0;
  for_candidates(origin, direction, -kInfinity, kInfinity, [&](std::uint32_t) { ++count; });
  return count;
}

Vec3 MeshRays::normal(const Hit& hit) const {
  const auto& corners = mesh_.triangles[hit.triangle];
  Vec3 sum = Vec3::Zero();
  if (!mesh_.normals.empty()) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& n = mesh_.normals[corners[c]];
      sum += hit.weight[c] * Vec3(double{n[0]}, double{n[1]}, double{n[2]});
    }
  }
  if (sum.isZero(0)) {
    const auto at = [&](std::size_t c) {
      return Vec3(Eigen::Map<const Vec3>(mesh_.positions[corners[c]].data()));
    };
    sum = (at(1) - at(0)).cross(at(2) - at(0));
  }
  const double length = sum.stableNorm();
  return length > 0 ? Vec3(sum / length) : Vec3(Vec3::Zero());
}

}  // namespace vol::mesh
