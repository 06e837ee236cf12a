#include <gtest/gtest.h>

#include "base/rng.h"
#include "curvilinear/solid.h"
#include "random_block.h"

namespace vol::curvilinear {
namespace {

template <class F>
void each_cell(const Block& block, const F& f) {
  const Dims n = block.cells();
  for (std::int64_t k = 0; k < n[2]; ++k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      for (std::int64_t i = 0; i < n[0]; ++i) f(Dims{i, j, k});
    }
  }
}

constexpr Dims kSizes[] = {{2, 2, 2}, {5, 4, 3}, {3, 2, 6}};

TEST(Solid, InterpolatesTheGridPointsToTheBit) {
  for (const Dims& dims : kSizes) {
    const Block block = random_block(dims, 1);
    for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
      const Solids solids(block, block.arrays[0].values, kind, 0.8);
      each_cell(block, [&](const Dims& c) {
        const Solid solid = solids(c);
        for (int n = 0; n < 8; ++n) {
          const Dims step{n & 1, n >> 1 & 1, n >> 2};
          const std::size_t at = block.offset(c[0] + step[0], c[1] + step[1], c[2] + step[2]);
          const Point4& b = solid.b[static_cast<std::size_t>(3 * (step[0] + 4 * (step[1] + 4 * step[2])))];
          EXPECT_EQ(b.head<3>(), block.points[at]);
          EXPECT_EQ(b[3], block.arrays[0].values[at]);
        }
      });
    }
  }
}

// Crossing rays rely on it: a face decided twice is decided alike.
TEST(Solid, NeighboursShareTheirFaceToTheBit) {
  for (const Dims& dims : kSizes) {
    const Block block = random_block(dims, 2);
    for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
      const Solids solids(block, block.arrays[0].values, kind, 1.3);
      each_cell(block, [&](const Dims& c) {
        for (std::size_t a = 0; a < 3; ++a) {
          if (c[a] + 2 >= dims[a]) continue;
          Dims next = c;
          ++next[a];
          const Solid one = solids(c), two = solids(next);
          for (std::size_t n = 0; n < 64; ++n) {
            const std::size_t stride = a == 0 ? 1 : a == 1 ? 4 : 16;
            if (n / stride % 4 != 0) continue;
            EXPECT_EQ(one.b[n + 3 * stride], two.b[n]) << "axis " << a;
          }
        }
      });
    }
  }
}

TEST(Solid, IsC1AcrossCells) {
  const Block block = random_block({5, 4, 6}, 3);
  for (const double beta : {0.5, 1.0, 1.7}) {
    const Solids solids(block, block.arrays[0].values, CellKind::tricubic, beta);
    Rng random(9);
    each_cell(block, [&](const Dims& c) {
      for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        if (c[axis] + 2 >= block.dims[axis]) continue;
        Dims next = c;
        ++next[axis];
        Vec3 u(random.uniform(), random.uniform(), random.uniform()), v = u;
        u[a] = 1;
        v[a] = 0;
        Eigen::Matrix<double, 4, 3> left, right;
        const Point4 p = solids(c)(u, left), q = solids(next)(v, right);
        // Positions are below 20: a few ulp of that, 4e-15, times the sums of four that a derivative takes.
        EXPECT_LT((p - q).cwiseAbs().maxCoeff(), 1e-12);
        EXPECT_LT((left - right).cwiseAbs().maxCoeff(), 1e-12);
      }
    });
  }
}

TEST(Solid, ReproducesLinearMapsAndFieldsBordersIncluded) {
  Mat3 map;
  map << 1.2, 0.3, -0.1, 0.2, 0.9, 0.4, -0.3, 0.1, 1.5;
  for (const Dims& dims : kSizes) {
    Block block = random_block(dims, 4, 0);
    each_cell({.dims = {dims[0] + 1, dims[1] + 1, dims[2] + 1}, .points = {}, .arrays = {}, .hidden = {}},
              [&](const Dims& p) {
                const Vec3 index(static_cast<double>(p[0]), static_cast<double>(p[1]),
                                 static_cast<double>(p[2]));
                const std::size_t n = block.offset(p[0], p[1], p[2]);
                block.points[n] = map * index + Vec3(5, -2, 1);
                block.arrays[0].values[n] = 2 - index.dot(Vec3(1, 2, 3));
              });
    for (const auto kind : {CellKind::tricubic, CellKind::trilinear}) {
      const Solids solids(block, block.arrays[0].values, kind, 1);
      Rng random(5);
      each_cell(block, [&](const Dims& c) {
        const Vec3 u(random.uniform(), random.uniform(), random.uniform());
        const Vec3 index =
            u + Vec3(static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2]));
        Eigen::Matrix<double, 4, 3> d;
        const Point4 p = solids(c)(u, d);
        EXPECT_LT((p.head<3>() - map * index - Vec3(5, -2, 1)).norm(), 1e-13);
        EXPECT_NEAR(p[3], 2 - index.dot(Vec3(1, 2, 3)), 1e-13);
        EXPECT_LT((d.topRows<3>() - map).norm(), 1e-12);
      });
    }
  }
}

TEST(Solid, CentresAreTheSolidThere) {
  const Block block = random_block({4, 4, 4}, 11);
  const Solid solid = Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 1});
  Eigen::Matrix<double, 4, 3> d, right;
  const auto compare = [&](const Point4& p, const Vec3& u) {
    EXPECT_LT((p - solid(u, right)).norm(), 1e-13);  // some ulp of coordinates below 20
    EXPECT_LT((d - right).norm(), 1e-12);
  };
  compare(solid.centre(d), {0.5, 0.5, 0.5});
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 u(0.5, 0.5, 0.5);
    u[axis] = 1;
    compare(solid.face_centre(axis, d), u);
  }
}

// The paper's formulas with their errata, point by point: an inner cell has all neighbours.
TEST(Solid, ControlPointsAreTheCorrectedFormulasOfThePaper) {
  const Block block = random_block({5, 6, 4}, 6);
  constexpr double kBeta = 0.7;
  const Solids solids(block, block.arrays[0].values, CellKind::tricubic, kBeta);
  const Dims c{2, 1, 1};
  const auto p = [&](std::int64_t i, std::int64_t j, std::int64_t k) -> Vec3 {
    return block.points[block.offset(c[0] + i, c[1] + j, c[2] + k)];
  };
  const Vec3 du = kBeta / 6 * (p(1, 0, 0) - p(-1, 0, 0)), dv = kBeta / 6 * (p(0, 1, 0) - p(0, -1, 0));
  const Vec3 duv = kBeta * kBeta / 36 * (p(1, 1, 0) - p(-1, 1, 0) - p(1, -1, 0) + p(-1, -1, 0));
  Vec3 sum = Vec3::Zero();  // the mixed third difference
  for (int n = 0; n < 8; ++n) {
    const int l = n & 1 ? 1 : -1, m = n & 2 ? 1 : -1, o = n & 4 ? 1 : -1;
    sum += l * m * o * p(l, m, o);
  }
  const Vec3 dw = kBeta / 6 * (p(0, 0, 1) - p(0, 0, -1));
  const Vec3 duw = kBeta * kBeta / 36 * (p(1, 0, 1) - p(-1, 0, 1) - p(1, 0, -1) + p(-1, 0, -1));
  const Vec3 dvw = kBeta * kBeta / 36 * (p(0, 1, 1) - p(0, -1, 1) - p(0, 1, -1) + p(0, -1, -1));
  const Vec3 duvw = kBeta * kBeta * kBeta / 216 * sum;
  const Solid solid = solids(c);
  const auto b = [&](std::size_t r, std::size_t s, std::size_t t) -> Vec3 {
    return solid.b[r + 4 * (s + 4 * t)].head<3>();
  };
  constexpr double kRounding = 1e-14;  // coordinates below 20, five sums
  EXPECT_LT((b(1, 0, 0) - p(0, 0, 0) - du).norm(), kRounding);
  EXPECT_LT((b(2, 0, 0) - p(1, 0, 0) + kBeta / 6 * (p(2, 0, 0) - p(0, 0, 0))).norm(), kRounding);
  EXPECT_LT((b(1, 1, 0) - p(0, 0, 0) - du - dv - duv).norm(), kRounding);
  EXPECT_LT((b(1, 1, 1) - p(0, 0, 0) - du - dv - dw - duv - duw - dvw - duvw).norm(), 2 * kRounding);
}

TEST(Solid, DerivativesAreThoseOfTheMap) {
  const Block block = random_block({4, 3, 5}, 7);
  const Solid solid = Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 2});
  Eigen::Matrix<double, 4, 3> d, ignored;
  const Vec3 u(0.31, 0.77, 0.52);
  const Point4 p = solid(u, d);
  EXPECT_LT((p - solid(u)).norm(), 1e-13);
  constexpr double kStep = 1e-5;  // error kStep^2 times third derivatives of some units, and 1e-15 / kStep
  for (int a = 0; a < 3; ++a) {
    const Vec3 e = kStep * Vec3::Unit(a);
    EXPECT_LT(((solid(u + e, ignored) - solid(u - e, ignored)) / (2 * kStep) - d.col(a)).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace vol::curvilinear
