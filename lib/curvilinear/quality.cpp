#include "curvilinear/quality.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "curvilinear/solid.h"

namespace vol::curvilinear {
namespace {

struct Corners {
  Vec3 p[8];
  Corners(const Block& block, const Dims& c) {
    for (int n = 0; n < 8; ++n) {
      p[n] = block.points[block.offset(c[0] + (n & 1), c[1] + (n >> 1 & 1), c[2] + (n >> 2))];
    }
  }
  [[nodiscard]] double centre_jacobian() const {
    Mat3 d;
    for (int a = 0; a < 3; ++a) {
      const int bit = 1 << a;
      d.col(a).setZero();
      for (int n = 0; n < 8; ++n) d.col(a) += (n & bit) != 0 ? p[n] : Vec3(-p[n]);
    }
    return (0.25 * d).determinant();
  }
  [[nodiscard]] bool has_collapsed_edge() const {
    for (int n = 0; n < 8; ++n) {
      for (int a = 0; a < 3; ++a) {
        if ((n >> a & 1) == 0 && p[n] == p[n | 1 << a]) return true;
      }
    }
    return false;
  }
};

constexpr int kEven = 4;  // points along an axis at which the Jacobian's sign is looked at

/// Cubic Bernstein polynomials and their derivatives at the even points: [point][polynomial].
struct EvenBasis {
  double value[kEven][4], derivative[kEven][4];
  EvenBasis() {
    for (int n = 0; n < kEven; ++n) {
      const double u = static_cast<double>(n) / (kEven - 1), v = 1 - u;
      const double b[4] = {v * v * v, 3 * u * v * v, 3 * u * u * v, u * u * u};
      const double q[5] = {0, v * v, 2 * u * v, u * u, 0};  // derivatives: differences of quadratic ones
      for (int r = 0; r < 4; ++r) {
        value[n][r] = b[r];
        derivative[n][r] = 3 * (q[r] - q[r + 1]);
      }
    }
  }
};

using Positions = std::array<Vec3, 64>;

/// Derivatives of the position along an axis at the even points, one axis of the array after another.
Positions derivatives(Positions p, int along) {
  static const EvenBasis kBasis;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& basis = axis == along ? kBasis.derivative : kBasis.value;
    const std::size_t stride = axis == 0 ? 1 : axis == 1 ? 4 : 16;
    for (std::size_t n = 0; n < 64; ++n) {
      if (n / stride % 4 != 0) continue;
      const Vec3 b[4] = {p[n], p[n + stride], p[n + 2 * stride], p[n + 3 * stride]};
      for (std::size_t i = 0; i < kEven; ++i) {
        p[n + i * stride] = basis[i][0] * b[0] + basis[i][1] * b[1] + basis[i][2] * b[2] + basis[i][3] * b[3];
      }
    }
  }
  return p;
}

/// Whether the Jacobian is clearly negative after `sign` somewhere.
bool folds(const Solid& solid, double sign) {
  Positions points;
  for (std::size_t n = 0; n < 64; ++n) points[n] = solid.b[n].head<3>();
  const Positions u = derivatives(points, 0), v = derivatives(points, 1), w = derivatives(points, 2);
  double lowest = 0, highest = 0;
  for (std::size_t n = 0; n < 64; ++n) {
    const double j = sign * u[n].cross(v[n]).dot(w[n]);
    lowest = std::min(lowest, j);
    highest = std::max(highest, j);
  }
  // Along a collapsed edge the Jacobian is 0, give or take its rounding.
  return lowest < -1e-12 * std::max(highest, -lowest);
}

struct Part {
  Quality q;
  bool any = false;
};

}  // namespace

Quality quality(const Block& block) {
  const Dims cells = block.cells();
  const auto each = [&](std::int64_t begin, std::int64_t end, const auto& f) {
    for (std::int64_t n = begin; n < end; ++n) {
      f(Dims{n % cells[0], n / cells[0] % cells[1], n / (cells[0] * cells[1])});
    }
  };
  constexpr std::int64_t kGrain = 1024;
  Part total = parallel_reduce<Part>(
      0, block.cell_count(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        Part part;
        each(begin, end, [&](const Dims& c) {
          const Corners corners(block, c);
          const double j = corners.centre_jacobian();
          part.q.jacobian_min = part.any ? std::min(part.q.jacobian_min, j) : j;
          part.q.jacobian_max = part.any ? std::max(part.q.jacobian_max, j) : j;
          part.any = true;
          part.q.volume += j;
          part.q.collapsed += corners.has_collapsed_edge();
          part.q.missing += block.is_missing(c);
        });
        return part;
      },
      [](Part& sum, const Part& part) {
        sum.q.jacobian_min =
            sum.any ? std::min(sum.q.jacobian_min, part.q.jacobian_min) : part.q.jacobian_min;
        sum.q.jacobian_max =
            sum.any ? std::max(sum.q.jacobian_max, part.q.jacobian_max) : part.q.jacobian_max;
        sum.any = true;
        sum.q.volume += part.q.volume;
        sum.q.collapsed += part.q.collapsed;
        sum.q.missing += part.q.missing;
      });
  const double sign = total.q.volume < 0 ? -1 : 1;
  const Solids solids(block, {}, CellKind::tricubic, 1);
  const Part signs = parallel_reduce<Part>(
      0, block.cell_count(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        Part part;
        each(begin, end, [&](const Dims& c) {
          part.q.inverted += !(sign * Corners(block, c).centre_jacobian() > 0);
          part.q.folded += folds(solids(c), sign);
        });
        return part;
      },
      [](Part& sum, const Part& part) {
        sum.q.inverted += part.q.inverted;
        sum.q.folded += part.q.folded;
      });
  total.q.inverted = signs.q.inverted;
  total.q.folded = signs.q.folded;
  return total.q;
}

double mean_cell_edge(const Grid& grid) {
  double volume = 0;
  std::int64_t cells = 0;
  for (const Block& block : grid.blocks) {
    const Dims n = block.cells();
    for (std::int64_t k = 0; k < n[2]; ++k) {
      for (std::int64_t j = 0; j < n[1]; ++j) {
        for (std::int64_t i = 0; i < n[0]; ++i) {
          if (block.is_missing({i, j, k})) continue;
          volume += std::abs(Corners(block, {i, j, k}).centre_jacobian());
          ++cells;
        }
      }
    }
  }
  return cells > 0 ? std::cbrt(volume / static_cast<double>(cells)) : 0;
}

}  // namespace vol::curvilinear
