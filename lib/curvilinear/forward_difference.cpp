#include "curvilinear/forward_difference.h"

#include "base/error.h"

namespace vol::curvilinear {
namespace {

void require_steps(const Lattice& lattice) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (lattice.steps[a] < 1 || lattice.steps[a] > kMostSteps || lattice.counts[a] < 1) {
      throw Error("forward differences: expected 1 to " + std::to_string(kMostSteps) +
                  " steps and a point or more, got " + std::to_string(lattice.steps[a]) + " and " +
                  std::to_string(lattice.counts[a]));
    }
  }
}

/// The differences at u = first / steps of the cubic with Bezier ordinates b, step 1 / steps: E M b.
template <class P>
void differences(const P& b0, const P& b1, const P& b2, const P& b3, double first, int steps, P (&d)[4]) {
  const double h = 1.0 / steps, u = first * h;
  // Taylor's coefficients at u, of step h: from the power basis at 0, whose sums are of differences of b.
  const P a1 = 3 * (b1 - b0), a2 = 3 * ((b2 - b1) - (b1 - b0)), a3 = (b3 - b0) - 3 * (b2 - b1);
  const P c1 = h * (a1 + u * (2 * a2 + 3 * u * a3)), c2 = h * h * (a2 + 3 * u * a3), c3 = h * h * h * a3;
  d[0] = b0 + u * (a1 + u * (a2 + u * a3));
  d[1] = c1 + c2 + c3;
  d[2] = 2 * c2 + 6 * c3;
  d[3] = 6 * c3;
}

}  // namespace

template <class T>
ForwardDifferences<T>::ForwardDifferences(const Solid& solid, const Point4& origin, const Lattice& lattice)
    : lattice_(lattice) {
  require_steps(lattice);
  // Control points that matter along each axis: all four, or the ends where the points are these.
  std::size_t step[3];
  for (std::size_t a = 0; a < 3; ++a) {
    const bool ends =
        lattice.steps[a] == 1 && lattice.first[static_cast<int>(a)] == 0 && lattice.counts[a] <= 2;
    step[a] = ends ? 3 : 1;
    if (ends) orders_[a] = 2;
  }
  std::array<Point4, 64> g;
  const auto along = [&](std::size_t axis, std::size_t n, std::size_t stride) {
    if (orders_[axis] == 2) {
      g[n + stride] = g[n + 3 * stride] - g[n];
      return;
    }
    Point4 d[4];
    differences(g[n], g[n + stride], g[n + 2 * stride], g[n + 3 * stride],
                lattice.first[static_cast<int>(axis)], lattice.steps[axis], d);
    for (std::size_t r = 0; r < 4; ++r) g[n + r * stride] = d[r];
  };
  for (std::size_t k = 0; k < 4; k += step[2]) {
    for (std::size_t j = 0; j < 4; j += step[1]) {
      const std::size_t row = 4 * j + 16 * k;
      for (std::size_t i = 0; i < 4; i += step[0]) g[i + row] = solid.b[i + row] - origin;
      along(0, row, 1);
    }
    for (std::size_t i = 0; i < orders_[0]; ++i) along(1, i + 16 * k, 4);
  }
  for (std::size_t j = 0; j < orders_[1]; ++j) {
    for (std::size_t i = 0; i < orders_[0]; ++i) along(2, i + 4 * j, 16);
  }
  for (std::size_t j = 0; j < orders_[1]; ++j) {
    for (std::size_t i = 0; i < orders_[0]; ++i) {
      Differences<T>& along_w = d_[i + 4 * j];
      for (std::size_t k = 0; k < 4; ++k) {
        if (k < orders_[2]) {
          along_w.d[k] = g[i + 4 * j + 16 * k].array().template cast<T>();
        } else {
          along_w.d[k].setZero();
        }
      }
    }
  }
}

template <class T>
ForwardDifferences<T> ForwardDifferences<T>::from_samples(const Solid& solid, const Point4& origin,
                                                          const Lattice& lattice) {
  require_steps(lattice);
  ForwardDifferences f;
  f.lattice_ = lattice;
  std::array<Point, 64> g;
  for (int n = 0; n < 64; ++n) {
    g[static_cast<std::size_t>(n)] =
        direct_point(solid, origin, lattice, {n & 3, n >> 2 & 3, n >> 4}).template cast<T>();
  }
  for (std::size_t stride = 1; stride < 64; stride *= 4) {
    for (int order = 1; order < 4; ++order) {
      for (std::size_t n = 64; n-- > 0;) {
        if (static_cast<int>(n / stride % 4) >= order) g[n] -= g[n - stride];
      }
    }
  }
  for (std::size_t n = 0; n < 16; ++n) {
    for (std::size_t k = 0; k < 4; ++k) f.d_[n].d[k] = g[n + 16 * k];
  }
  return f;
}

template class ForwardDifferences<float>;
template class ForwardDifferences<double>;

Eigen::Array<long double, 4, 1> direct_point(const Solid& solid, const Point4& origin, const Lattice& lattice,
                                             const std::array<int, 3>& at) {
  using Long = long double;
  Long b[3][4];
  for (std::size_t a = 0; a < 3; ++a) {
    const Long u = (Long(lattice.first[static_cast<int>(a)]) + Long(at[a])) / Long(lattice.steps[a]),
               v = 1 - u;
    b[a][0] = v * v * v;
    b[a][1] = 3 * u * v * v;
    b[a][2] = 3 * u * u * v;
    b[a][3] = u * u * u;
  }
  Eigen::Array<Long, 4, 1> sum = Eigen::Array<Long, 4, 1>::Zero();
  for (std::size_t n = 0; n < 64; ++n) {
    const Eigen::Array<Long, 4, 1> p = solid.b[n].array().cast<Long>() - origin.array().cast<Long>();
    sum += b[0][n % 4] * b[1][n / 4 % 4] * b[2][n / 16] * p;
  }
  return sum;
}

}  // namespace vol::curvilinear
