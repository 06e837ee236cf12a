#include <gtest/gtest.h>

#include <algorithm>

#include "base/rng.h"
#include "curvilinear/ray_patch.h"
#include "ray_oracle.h"

namespace vol::curvilinear {
namespace {

Vec3 random_vector(Rng& random) {
  return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

/// A patch over the unit square, bent by `bend`: above 0.5 it folds.
FacePatch random_patch(Rng& random, double bend) {
  FacePatch patch;
  for (int n = 0; n < 16; ++n) {
    patch[static_cast<std::size_t>(n)] =
        Vec3(n % 4 / 3.0, n / 4 / 3.0, 0) + bend * random_vector(random) + Vec3(5, -3, 2);
  }
  return patch;
}

Vec3 at(const FacePatch& patch, double u, double v) {
  const auto b = [](double x, int k) {
    const double y = 1 - x;
    return k == 0 ? y * y * y : k == 1 ? 3 * x * y * y : k == 2 ? 3 * x * x * y : x * x * x;
  };
  Vec3 p = Vec3::Zero();
  for (int n = 0; n < 16; ++n) p += b(u, n % 4) * b(v, n / 4) * patch[static_cast<std::size_t>(n)];
  return p;
}

int sum_of_signs(const std::vector<PatchHit>& hits) {
  int sum = 0;
  for (const auto& hit : hits) sum += hit.sign;
  return sum;
}

// Rays through random points of patches that are plain, bent and folded: the same passages as halving and
// Newton find in extended precision. Their depth to 1e-9 (patches of size 1): a pair near a fold at a
// distance of s in u has a Jacobian of s, and the control points of rounding 1e-15 move it by 1e-15 / s;
// pairs nearer than 1e-4 are told by neither for sure and are not compared.
TEST(RayPatch, MeetsWhatExtendedPrecisionMeets) {
  Rng random(1);
  int compared = 0, folded = 0;
  for (int n = 0; n < 3000; ++n) {
    const FacePatch patch = random_patch(random, n % 3 * 0.4);
    const Vec3 direction = (Vec3(0, 0, 1) + (n % 2) * 2 * random_vector(random)).normalized();
    const Vec3 target = at(patch, random.uniform(-0.1, 1.1), random.uniform(-0.1, 1.1));
    const camera::Ray ray{target - random.uniform(1, 20) * direction, direction};
    auto expected = RayOracle(ray).hits(patch);
    std::vector<PatchHit> hits;
    const RayFrame frame(ray, Vec3(5, -3, 2));
    const RayPatch seen(patch, frame);
    append_hits(seen, hits);
    ASSERT_EQ(sum_of_signs(hits), winding(seen)) << n;
    bool close = false;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const auto& p = expected[i];
      close = close || std::min({p.u, p.v, 1 - p.u, 1 - p.v}) < 1e-12L;
      for (std::size_t j = 0; j < i; ++j) {
        close = close || std::max(std::abs(p.u - expected[j].u), std::abs(p.v - expected[j].v)) < 1e-4L;
      }
    }
    if (close) continue;
    ++compared;
    folded += expected.size() > 1;
    ASSERT_EQ(hits.size(), expected.size()) << n;
    std::sort(expected.begin(), expected.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
    std::sort(hits.begin(), hits.end(), [](const auto& a, const auto& b) { return a.z < b.z; });
    for (std::size_t i = 0; i < hits.size(); ++i) {
      EXPECT_NEAR(frame.t_origin + hits[i].z, static_cast<double>(expected[i].t), 1e-9) << n;
      EXPECT_EQ(hits[i].sign, expected[i].sign) << n;
      EXPECT_LT((at(patch, hits[i].u, hits[i].v) - frame.origin - hits[i].z * frame.along).norm(), 1e-12)
          << n;
    }
  }
  EXPECT_GT(compared, 2900);
  EXPECT_GT(folded, 200);
}

/// The six faces of a cell of random control points, outward, as Face orients them.
struct Cell {
  std::array<Vec3, 64> b;

  [[nodiscard]] FacePatch face(int axis, bool high) const {
    FacePatch patch;
    const int stride[3] = {1, 4, 16};
    for (int s = 0; s < 4; ++s) {
      for (int r = 0; r < 4; ++r) {
        const int n = (high ? 3 : 0) * stride[axis] + r * stride[(axis + 1) % 3] + s * stride[(axis + 2) % 3];
        patch[static_cast<std::size_t>(r + 4 * s)] = b[static_cast<std::size_t>(n)];
      }
    }
    return patch;
  }
  [[nodiscard]] std::size_t number(int i, int j, int k) const {
    return static_cast<std::size_t>(i + 4 * (j + 4 * k));
  }
};

/// A lattice of whole numbers, so that rays along axes meet edges and corners exactly, and run within faces.
Cell lattice_cell() {
  Cell cell;
  for (int n = 0; n < 64; ++n) cell.b[static_cast<std::size_t>(n)] = Vec3(n % 4, n / 4 % 4, n / 16);
  return cell;
}

int sum_over_faces(const Cell& cell, const camera::Ray& ray, int& crossings) {
  const RayFrame frame(ray, cell.b[21]);
  int sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool high : {false, true}) {
      const RayPatch patch(cell.face(axis, high), frame);
      std::vector<PatchHit> hits;
      append_hits(patch, hits);
      EXPECT_EQ(sum_of_signs(hits), winding(patch));
      sum += (high ? 1 : -1) * sum_of_signs(hits);
      crossings += static_cast<int>(hits.size());
    }
  }
  return sum;
}

// The boundary of a cell is closed: what enters leaves. Exactly, for rays aimed at its control points, edges
// and faces, along its edges and within its faces, for cells that are plain, torn by jitter, with edges and
// faces collapsed to points and lines, and flat.
TEST(RayPatch, WhatEntersACellLeavesIt) {
  Rng random(2);
  int crossings = 0;
  for (int n = 0; n < 20000; ++n) {
    Cell cell = lattice_cell();
    const double jitter[4] = {0, 0.3, 2, 1e-15};
    for (auto& p : cell.b) p += jitter[n % 4] * random_vector(random);
    const int shape = n / 4 % 5;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        if (shape == 1) cell.b[cell.number(j, 0, 0)] = cell.b[0];                     // an edge to a point
        if (shape == 2) cell.b[cell.number(0, i, j)] = cell.b[cell.number(0, i, 0)];  // a face to a curve
        if (shape == 3) cell.b[cell.number(i, j, 0)] = cell.b[0];                     // a face to a point
        for (int k = 0; k < 4 && shape == 4; ++k) cell.b[cell.number(i, j, k)] = cell.b[cell.number(i, j, 0)];
      }
    }
    const Vec3 a = cell.b[random.below(64)], b = cell.b[random.below(64)];
    const double along = n / 20 % 3 == 0 ? 0.0 : random.uniform();
    Vec3 direction =
        n / 60 % 2 == 0 ? random_vector(random) : Vec3(Vec3::Unit(static_cast<int>(random.below(3))));
    if (n / 120 % 4 == 0 && a != b) direction = b - a;  // along edges, diagonals of faces, ...
    direction.normalize();
    const Vec3 target = a + along * (b - a);
    const int sum = sum_over_faces(cell, {target - random.uniform(0, 10) * direction, direction}, crossings);
    ASSERT_EQ(sum, 0) << n;
  }
  EXPECT_GT(crossings, 20000);
}

}  // namespace
}  // namespace vol::curvilinear
