#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/rng.h"
#include "render/isosurface_rays.h"

namespace vol::render {

__extension__ using Quad = __float128;

inline Quad root_of(Quad x) {
  if (x <= 0) return 0;
  Quad r = std::sqrt(static_cast<double>(x));
  for (int n = 0; n < 4; ++n) r = (r + x / r) / 2;
  return r;
}

/// White noise; `share` of it, the rest below all isovalues asked for.
inline volume::Volume random_volume(Rng& rng, const Dims& dims, double share = 1) {
  volume::Grid<float> grid;
  grid.geometry.dims = dims;
  grid.geometry.spacing = {0.7, 1.3, 1};
  grid.geometry.origin = {-3, 5, 2};
  grid.geometry.direction =
      (Eigen::AngleAxisd(0.6, Vec3::UnitY()) * Eigen::AngleAxisd(0.3, Vec3::UnitX())).toRotationMatrix();
  grid.voxels = Buffer<float>(static_cast<std::size_t>(grid.geometry.count()));
  for (float& v : grid.voxels) {
    v = static_cast<float>(rng.uniform() < share ? rng.uniform(-1, 1) : rng.uniform(-1, 0));
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  return volume;
}

inline camera::Ray random_ray(Rng& rng, const volume::FieldBounds& bounds) {
  // Through a point in the box, from outside; every eighth along an axis of the grid.
  const Vec3 p = bounds.corner + bounds.edges * Vec3(rng.uniform(), rng.uniform(), rng.uniform());
  Vec3 d(rng.normal(), rng.normal(), rng.normal());
  if (rng.below(8) == 0) d = bounds.edges.col(static_cast<Eigen::Index>(rng.below(3)));
  d.normalize();
  return {p - 2 * bounds.longest_edge() * d, d};
}

/// The first change of side along a ray by the exact cubic in each cell, in quadruple precision: pieces
/// between the cubic's two extrema are monotone, so that signs at their ends tell all. The isovalue is
/// subtracted from the samples first and a plane of samples is met exactly, so that ties are 0 but for 1e-30.
struct Truth {
  std::optional<double> t;
  Vec3 gradient = Vec3::Zero();  ///< index space, of the cell that holds the crossing
  bool starts_inside = false;    ///< where the chord begins
  bool judged = true;  ///< no value but 0 within 1e-12 of the isovalue at an extremum or a cell's face, up to
                       ///< the hit
};

template <class T>
Truth exact_first_hit(const volume::Grid<T>& grid, const camera::Ray& ray, const Chord& chord,
                      double isovalue) {
  struct Plane {
    double t;
    int axis;
    double x;
  };
  const Mat3 to_index = grid.geometry.world_to_index_matrix();
  const Vec3 o = to_index * (ray.origin - grid.geometry.origin);
  const Vec3 d = to_index * ray.direction;
  std::vector<Plane> planes;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = grid.dims()[static_cast<std::size_t>(a)];
    if (d[a] == 0 || n == 1) continue;
    for (std::int64_t k = 0; k < n; ++k) planes.push_back({(double(k) - o[a]) / d[a], a, double(k)});
  }
  std::sort(planes.begin(), planes.end(), [](const Plane& a, const Plane& b) { return a.t < b.t; });
  std::erase_if(planes, [&](const Plane& p) {
    return std::abs(p.t - 0.5 * (chord.entry + chord.exit)) > 0.5 * chord.length() + 1e-11;
  });
  // A chord may begin and end within the box, at the eye or at the border of an axis of one sample.
  if (planes.empty() || planes.front().t > chord.entry + 1e-11)
    planes.insert(planes.begin(), {chord.entry, -1, 0});
  if (planes.back().t < chord.exit - 1e-11) planes.push_back({chord.exit, -1, 0});
  Truth truth;
  bool first = true;
  for (std::size_t n = 0; n + 1 < planes.size(); ++n) {
    const Quad t0 = planes[n].t;
    const Quad width = Quad(planes[n + 1].t) - t0;
    if (width <= Quad(1e-13)) continue;
    std::int64_t cell[3];
    Quad at[3], slope[3];
    for (int a = 0; a < 3; ++a) {
      const std::int64_t last = grid.dims()[static_cast<std::size_t>(a)] - 2;
      const double middle = o[a] + 0.5 * (planes[n].t + planes[n + 1].t) * d[a];
      cell[a] =
          last < 0 ? 0 : std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(middle)), 0, last);
      at[a] = planes[n].axis == a ? Quad(planes[n].x) : Quad(o[a]) + t0 * Quad(d[a]);
      const Quad to =
          planes[n + 1].axis == a ? Quad(planes[n + 1].x) : Quad(o[a]) + Quad(planes[n + 1].t) * Quad(d[a]);
      slope[a] = to - at[a];
      at[a] -= Quad(cell[a]);
      if (last < 0) at[a] = slope[a] = 0;
    }
    const auto sample = [&](int corner) {
      std::int64_t i[3];
      for (int a = 0; a < 3; ++a)
        i[a] = std::min(cell[a] + (corner >> a & 1), grid.dims()[static_cast<std::size_t>(a)] - 1);
      return Quad(static_cast<double>(grid(i[0], i[1], i[2]))) - Quad(isovalue);
    };
    Quad c[4] = {0, 0, 0, 0};
    for (int corner = 0; corner < 8; ++corner) {
      Quad w[4] = {sample(corner), 0, 0, 0};
      for (int a = 0; a < 3; ++a) {
        const bool upper = (corner >> a & 1) != 0;
        const Quad c0 = upper ? at[a] : 1 - at[a];
        const Quad c1 = upper ? slope[a] : -slope[a];
        for (int k = 3; k >= 0; --k) w[k] = w[k] * c0 + (k > 0 ? w[k - 1] * c1 : Quad(0));
      }
      for (int k = 0; k < 4; ++k) c[k] += w[k];
    }
    const auto f = [&](Quad u) {
      const Quad v = c[0] + u * (c[1] + u * (c[2] + u * c[3]));
      return (v < 0 ? -v : v) < Quad(1e-29) ? Quad(0) : v;
    };
    std::vector<Quad> ends{0};
    const Quad disc = c[2] * c[2] - 3 * c[1] * c[3];
    if (disc > 0) {
      const Quad q = -(c[2] + (c[2] < 0 ? -1 : 1) * root_of(disc));
      for (const Quad u : {c[3] != 0 ? q / (3 * c[3]) : Quad(-1), q != 0 ? c[1] / q : Quad(-1)}) {
        if (u > 0 && u < 1) ends.push_back(u);
      }
      std::sort(ends.begin(), ends.end());
    }
    ends.push_back(1);
    if (first) truth.starts_inside = f(0) >= 0;
    first = false;
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      const Quad low = f(ends[e]);
      const Quad high = f(ends[e + 1]);
      // The range of values is 2 or a few.
      for (const Quad v : {low, high})
        truth.judged = truth.judged && (v == 0 || (v < 0 ? -v : v) > Quad(2e-12));
      if ((low >= 0) == (high >= 0)) continue;
      Quad a = ends[e], b = ends[e + 1];
      for (int step = 0; step < 60; ++step) {
        const Quad m = (a + b) / 2;
        ((f(m) >= 0) == (low >= 0) ? a : b) = m;
      }
      const Quad u = (a + b) / 2;
      truth.t = static_cast<double>(t0 + width * u);
      for (int corner = 0; corner < 8; ++corner) {
        for (int axis = 0; axis < 3; ++axis) {
          Quad w = sample(corner);
          for (int other = 0; other < 3; ++other) {
            const bool upper = (corner >> other & 1) != 0;
            const Quad x = at[other] + u * slope[other];
            w *= other == axis ? Quad(upper ? 1 : -1) : upper ? x : 1 - x;
          }
          truth.gradient[axis] += static_cast<double>(w);
        }
      }
      return truth;
    }
  }
  return truth;
}

}  // namespace vol::render
