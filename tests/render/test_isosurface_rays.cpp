#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "isosurface/marching_cubes.h"
#include "render/grid_field.h"
#include "render/isosurface_rays.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

__extension__ using Quad = __float128;

Quad root_of(Quad x) {
  if (x <= 0) return 0;
  Quad r = std::sqrt(static_cast<double>(x));
  for (int n = 0; n < 4; ++n) r = (r + x / r) / 2;
  return r;
}

/// White noise; `share` of it, the rest below all isovalues asked for.
volume::Volume random_volume(Rng& rng, const Dims& dims, double share = 1) {
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

camera::Ray random_ray(Rng& rng, const volume::FieldBounds& bounds) {
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

/// The usual way: signs at steps of half a voxel.
std::optional<double> sign_test(const FieldView& field, const camera::Ray& ray, const Chord& chord,
                                double isovalue) {
  const double step = 0.35;  // half the smallest spacing
  bool inside = field.value(ray.origin + chord.entry * ray.direction) >= isovalue;
  for (double t = chord.entry + step;; t += step) {
    const double at = std::min(t, chord.exit);
    if ((field.value(ray.origin + at * ray.direction) >= isovalue) != inside) return at;
    if (at >= chord.exit) return std::nullopt;
  }
}

struct Tally {
  std::int64_t rays = 0, unjudged = 0, hits = 0, missed = 0, invented = 0, misplaced = 0,
               sign_test_missed = 0;
};

// No hit missed, none invented, depth to 1e-6 voxel: the cubic's Bernstein coefficients are off by some 1e-16
// and its slope at a hit that is judged may be as low as 1e-6 (an extremum 1e-12 away), so that t is good to
// 1e-9.
TEST(IsosurfaceRays, MeetWhatTheExactCubicMeets) {
  const char* text = std::getenv("PRECIS_TEST_RAYS");
  const std::int64_t rays = text != nullptr ? std::atoll(text) : 40000;
  constexpr std::int64_t kAVolume = 1000;
  const Tally tally = parallel_reduce<Tally>(
      0, rays / kAVolume, 1,
      [&](std::int64_t begin, std::int64_t end) {
        Tally part;
        for (std::int64_t n = begin; n < end; ++n) {
          Rng rng(static_cast<std::uint64_t>(7000 + n));
          // Every eighth with many macrocells, most of them empty.
          const bool sparse = n % 8 == 0;
          const volume::Volume volume =
              sparse ? random_volume(rng, {21, 18, 19}, 0.002) : random_volume(rng, {5, 4, 6});
          const auto& grid = std::get<volume::Grid<float>>(volume.grid);
          const double isovalue = rng.uniform(0.1, 0.7);
          const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, isovalue, false);
          const GridField field(volume, volume::Reconstruction::trilinear);
          const RayBox box(surface.bounds());
          IsosurfaceRays::Counts counts;
          for (int r = 0; r < kAVolume; ++r) {
            const camera::Ray ray = random_ray(rng, surface.bounds());
            const auto chord = box.chord(ray, 0);
            if (!chord) continue;
            ++part.rays;
            const Truth truth = exact_first_hit(grid, ray, *chord, isovalue);
            const auto hit = surface.first_hit(ray, *chord, counts);
            if (!truth.judged) {
              ++part.unjudged;
              continue;
            }
            part.hits += truth.t.has_value();
            part.missed += truth.t && !hit;
            part.invented += hit && !truth.t;
            part.misplaced += hit && truth.t && !(std::abs(hit->t - *truth.t) < 0.7e-6);
            const auto stepped = sign_test(field.view(), ray, *chord, isovalue);
            part.sign_test_missed += truth.t && !(stepped && *stepped <= *truth.t + 0.35 + 1e-9);
          }
        }
        return part;
      },
      [](Tally& sum, const Tally& part) {
        sum.rays += part.rays;
        sum.unjudged += part.unjudged;
        sum.hits += part.hits;
        sum.missed += part.missed;
        sum.invented += part.invented;
        sum.misplaced += part.misplaced;
        sum.sign_test_missed += part.sign_test_missed;
      });
  std::printf(
      "rays %lld, hits %lld, not judged %lld; missed %lld, invented %lld, misplaced %lld; half-voxel sign "
      "test missed %lld\n",
      static_cast<long long>(tally.rays), static_cast<long long>(tally.hits),
      static_cast<long long>(tally.unjudged), static_cast<long long>(tally.missed),
      static_cast<long long>(tally.invented), static_cast<long long>(tally.misplaced),
      static_cast<long long>(tally.sign_test_missed));
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.invented, 0);
  EXPECT_EQ(tally.misplaced, 0);
  EXPECT_GT(tally.hits, tally.rays / 3);
  EXPECT_LT(tally.unjudged, tally.rays / 1000);
  EXPECT_GT(tally.sign_test_missed, 0);  // or the rays are too easy
}

// The cubics' degree 9: no sign changes on a dense scan before the hit, and the value there is the isovalue.
// The field's slope is below 20 a voxel here, the hit good to 1e-14 of a cell, the spline's sums to 1e-14.
TEST(IsosurfaceRays, CubicsHitBeforeAnyChangeOfSign) {
  for (const auto kernel : {volume::Reconstruction::catmull_rom, volume::Reconstruction::b_spline}) {
    Rng rng(91);
    int hits = 0;
    for (int n = 0; n < 10; ++n) {
      const volume::Volume volume = random_volume(rng, {9, 8, 10});
      const double isovalue = rng.uniform(0.2, 0.8);
      const IsosurfaceRays surface(volume, kernel, isovalue, false);
      const GridField field(volume, kernel);
      const RayBox box(surface.bounds());
      IsosurfaceRays::Counts counts;
      for (int r = 0; r < 60; ++r) {
        const camera::Ray ray = random_ray(rng, surface.bounds());
        const auto chord = box.chord(ray, 0);
        if (!chord) continue;
        const auto hit = surface.first_hit(ray, *chord, counts);
        const double end = hit ? hit->t - 1e-6 : chord->exit;
        const auto value = [&](double t) { return field.view().value(ray.origin + t * ray.direction); };
        const bool inside = value(chord->entry) >= isovalue;
        constexpr int kScan = 3000;
        for (int i = 0; i <= kScan; ++i) {
          const double t = chord->entry + (end - chord->entry) * i / kScan;
          ASSERT_EQ(value(t) >= isovalue, inside) << "ray " << r << " at " << t;
        }
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(value(hit->t), isovalue, 1e-11);
        // Differences of the field, against the normal: errors of h^2 and 1e-15 / h.
        constexpr double h = 1e-5;
        Vec3 gradient;
        for (int a = 0; a < 3; ++a) {
          const Vec3 step = h * Vec3::Unit(a);
          gradient[a] =
              (field.view().value(hit->position + step) - field.view().value(hit->position - step)) / (2 * h);
        }
        // Second derivatives jump between Catmull-Rom's cells: errors of h.
        if (gradient.norm() > 0.05) {
          EXPECT_LT((hit->normal + gradient.normalized()).norm(), 5e-3);
        }
      }
    }
    EXPECT_GT(hits, 100);
  }
}

/// First hit of a ray with a mesh, every triangle tried (Moeller & Trumbore 1997); the triangle's number.
std::optional<std::pair<double, std::size_t>> mesh_hit(const mesh::TriangleMesh& mesh,
                                                       const camera::Ray& ray) {
  std::optional<std::pair<double, std::size_t>> first;
  const auto at = [&](std::uint32_t v) { return Vec3(Eigen::Map<const Vec3>(mesh.positions[v].data())); };
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const Vec3 a = at(mesh.triangles[n][0]);
    const Vec3 e1 = at(mesh.triangles[n][1]) - a;
    const Vec3 e2 = at(mesh.triangles[n][2]) - a;
    const Vec3 p = ray.direction.cross(e2);
    const double det = e1.dot(p);
    if (det == 0) continue;
    const Vec3 s = ray.origin - a;
    const double u = s.dot(p) / det;
    const Vec3 q = s.cross(e1);
    const double v = ray.direction.dot(q) / det;
    const double t = e2.dot(q) / det;
    if (u < 0 || v < 0 || u + v > 1 || t < 0) continue;
    if (!first || t < first->first) first = {t, n};
  }
  return first;
}

// A surface by rays and its mesh by rays: as far apart, across the surface, as the mesh's chords are from the
// surface, measured on the triangles themselves; a quarter more, for what the sampling of 15 points a
// triangle misses. Rays that meet one but not the other, or another sheet, graze.
TEST(IsosurfaceRays, AgreeWithTheMeshToItsChordError) {
  volume::Grid<double> grid;
  grid.geometry.dims = {17, 19, 18};
  grid.geometry.spacing = {1, 0.9, 0.95};
  grid.voxels = Buffer<double>(static_cast<std::size_t>(grid.geometry.count()));
  const Vec3 centre(8.1, 8.2, 8.05);
  for (std::int64_t k = 0; k < 18; ++k) {
    for (std::int64_t j = 0; j < 19; ++j) {
      for (std::int64_t i = 0; i < 17; ++i) {
        const Vec3 p = grid.geometry.index_to_world(Vec3(double(i), double(j), double(k))) - centre;
        grid(i, j, k) = 2.1 - std::hypot(std::hypot(p[0], p[1]) - 4.6, p[2]);  // a torus
      }
    }
  }
  volume::Volume volume;
  volume.grid = std::move(grid);
  const auto mesh = isosurface::marching_cubes(volume, 0).mesh;
  const GridField field(volume, volume::Reconstruction::trilinear);
  double chord_error = 0;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i <= 4; ++i) {
      for (int j = 0; i + j <= 4; ++j) {
        const double w[3] = {i / 4.0, j / 4.0, (4 - i - j) / 4.0};
        Vec3 p = Vec3::Zero();
        for (std::size_t c = 0; c < 3; ++c) p += w[c] * Eigen::Map<const Vec3>(mesh.positions[t[c]].data());
        // The distance function's slope is 1, the trilinear field's nearly.
        chord_error =
            std::max(chord_error, std::abs(field.view().value(p)) / field.view().gradient(p).norm());
      }
    }
  }
  const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, 0, false);
  const RayBox box(surface.bounds());
  Rng rng(95);
  IsosurfaceRays::Counts counts;
  int both = 0;
  int apart = 0;
  for (int n = 0; n < 1500; ++n) {
    const camera::Ray ray = random_ray(rng, surface.bounds());
    const auto chord = box.chord(ray, 0);
    if (!chord) continue;
    const auto hit = surface.first_hit(ray, *chord, counts);
    const auto other = mesh_hit(mesh, ray);
    if (hit.has_value() != other.has_value() || (hit && std::abs(hit->t - other->first) > 1)) {
      ++apart;
      continue;
    }
    if (!hit) continue;
    const double slope = std::abs(hit->normal.dot(ray.direction));
    if (slope < 0.2) continue;  // grazing: both surfaces bend away under the ray
    ++both;
    EXPECT_LE(std::abs(hit->t - other->first) * slope, 1.25 * chord_error) << "ray " << n;
  }
  EXPECT_GT(both, 400);
  EXPECT_LT(apart, 15);
  EXPECT_LT(chord_error, 0.2);
}

// Two roots 1e-6 of the interval apart, anywhere in it.
TEST(FirstCrossing, PairsOfRootsAreNotSkipped) {
  Rng rng(92);
  for (int n = 0; n < 2000; ++n) {
    const double root = rng.uniform(0.05, 0.95);
    const double gap = 1e-6;
    // (u - r)(u - r - gap)(u + 1), by its blossom: b_k = mean over which factors are taken at 1.
    const double at0[3] = {-root, -root - gap, 1};
    const double at1[3] = {1 - root, 1 - root - gap, 2};
    Bernstein p;
    p.degree = 3;
    p.b[0] = at0[0] * at0[1] * at0[2];
    p.b[1] = (at1[0] * at0[1] * at0[2] + at0[0] * at1[1] * at0[2] + at0[0] * at0[1] * at1[2]) / 3;
    p.b[2] = (at1[0] * at1[1] * at0[2] + at1[0] * at0[1] * at1[2] + at0[0] * at1[1] * at1[2]) / 3;
    p.b[3] = at1[0] * at1[1] * at1[2];
    const auto u = first_crossing(p, 0);
    ASSERT_TRUE(u.has_value()) << root;
    // The dip is 2.5e-13 deep: rounding of 1e-16 moves its side by about 1e-16 / 1e-6.
    EXPECT_NEAR(*u, root, 1e-8);
  }
}

TEST(FirstCrossing, TiesAreInside) {
  Bernstein p;
  p.degree = 1;
  p.b = {0, 1};
  EXPECT_FALSE(first_crossing(p, 0).has_value());  // at least 0 throughout
  p.b = {-1, 0};
  EXPECT_NEAR(first_crossing(p, 0).value(), 1, 1e-14);
  p.b = {0, -1};
  EXPECT_NEAR(first_crossing(p, 0).value(), 0, 1e-14);
}

// A closed volume all inside is its box, with the box's normals.
TEST(IsosurfaceRays, ClosedBorderIsSurface) {
  Rng rng(93);
  volume::Volume volume = random_volume(rng, {4, 5, 6});
  const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, -2, true);
  const IsosurfaceRays open(volume, volume::Reconstruction::trilinear, -2, false);
  const RayBox box(surface.bounds());
  IsosurfaceRays::Counts counts;
  for (int n = 0; n < 100; ++n) {
    const camera::Ray ray = random_ray(rng, surface.bounds());
    const auto chord = box.chord(ray, 0);
    ASSERT_TRUE(chord);
    const auto hit = surface.first_hit(ray, *chord, counts);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->t, chord->entry);
    EXPECT_LT(hit->normal.dot(ray.direction), 0);
    EXPECT_FALSE(open.first_hit(ray, *chord, counts));
  }
  EXPECT_THROW(IsosurfaceRays(volume, volume::Reconstruction::nearest, 0, false), Error);
  EXPECT_THROW(IsosurfaceRays(volume, volume::Reconstruction::trilinear, std::nan(""), false), Error);
}

volume::Volume constant(float value, bool eight_bits, const Dims& dims) {
  Rng rng(96);
  volume::Volume volume = random_volume(rng, dims);
  auto& grid = std::get<volume::Grid<float>>(volume.grid);
  std::fill(grid.voxels.begin(), grid.voxels.end(), value);
  if (!eight_bits) return volume;
  volume::Grid<std::uint8_t> bytes;
  bytes.geometry = grid.geometry;
  bytes.voxels = Buffer<std::uint8_t>(grid.voxels.size());
  std::fill(bytes.voxels.begin(), bytes.voxels.end(), static_cast<std::uint8_t>(value));
  volume::Volume other;
  other.grid = std::move(bytes);
  return other;
}

// All samples equal the isovalue: all is inside. Closed it is its box, open it has no surface.
TEST(IsosurfaceRays, ConstantsAtTheIsovalueAreInside) {
  for (const auto kernel : {volume::Reconstruction::trilinear, volume::Reconstruction::catmull_rom,
                            volume::Reconstruction::b_spline}) {
    for (const float value : {7.0F, 13.0F, 255.0F, 0.1F, 0.0F}) {
      const volume::Volume volume = constant(value, value >= 1, {11, 9, 10});
      const IsosurfaceRays closed(volume, kernel, double{value}, true);
      const IsosurfaceRays open(volume, kernel, double{value}, false);
      const RayBox box(closed.bounds());
      Rng rng(97);
      IsosurfaceRays::Counts counts;
      for (int n = 0; n < 300; ++n) {
        const camera::Ray ray = random_ray(rng, closed.bounds());
        const auto chord = box.chord(ray, 0);
        ASSERT_TRUE(chord);
        const auto hit = closed.first_hit(ray, *chord, counts);
        ASSERT_TRUE(hit) << value << ", ray " << n;
        EXPECT_EQ(hit->t, chord->entry);
        EXPECT_FALSE(open.first_hit(ray, *chord, counts)) << value << ", ray " << n;
      }
    }
  }
}

// Integers, the isovalue one of them: plateaus, faces and edges at the isovalue everywhere. On grids with
// mirrored axes and axes of one sample, from outside and from within, open and closed. Normals where the
// gradient is not 0 are the oracle's: of the cell that the oracle finds the crossing in, or, where a
// crossing lies on a plane of samples, perhaps the next one's.
TEST(IsosurfaceRays, MeetIntegersAtTheIsovalue) {
  std::int64_t rays = 0, judged = 0, hits = 0, wrong = 0, misplaced = 0, zero = 0, inward = 0, off = 0,
               within = 0;
  for (int n = 0; n < 60; ++n) {
    Rng rng(static_cast<std::uint64_t>(9000 + n));
    Dims dims{7, 5, 6};
    if (n % 4 == 3) dims[static_cast<std::size_t>(rng.below(3))] = 1;
    volume::Volume volume = random_volume(rng, dims);
    auto& grid = std::get<volume::Grid<float>>(volume.grid);
    const int most = n % 3 == 0 ? 1 : 3;
    for (float& v : grid.voxels) v = static_cast<float>(rng.below(static_cast<std::uint64_t>(most + 1)));
    if (n % 2 == 1) grid.geometry.direction.col(static_cast<Eigen::Index>(rng.below(3))) *= -1;
    const double isovalue = 1 + static_cast<double>(rng.below(static_cast<std::uint64_t>(most)));
    const bool close = n % 5 < 2;
    const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, isovalue, close);
    const RayBox box(surface.bounds());
    IsosurfaceRays::Counts counts;
    for (int r = 0; r < 400; ++r) {
      camera::Ray ray = random_ray(rng, surface.bounds());
      const bool eye_within = r % 4 == 0;
      if (eye_within) {
        const Vec3 u(rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.95));
        ray.origin = surface.bounds().corner + surface.bounds().edges * u;
      }
      const auto chord = box.chord(ray, 0);
      if (!chord) continue;
      ++rays;
      const Truth truth = exact_first_hit(grid, ray, *chord, isovalue);
      const auto hit = surface.first_hit(ray, *chord, counts);
      if (!truth.judged) continue;
      ++judged;
      within += eye_within;
      std::optional<double> expected = truth.t;
      bool border = false;
      if (close && truth.starts_inside && !eye_within) {
        expected = chord->entry;
        border = true;
      } else if (close && truth.starts_inside && !expected) {
        expected = chord->exit;
        border = true;
      }
      wrong += expected.has_value() != hit.has_value();
      if (!expected || !hit) continue;
      ++hits;
      misplaced += !(std::abs(*expected - hit->t) < 1e-6);
      zero += !(std::abs(hit->normal.norm() - 1) < 1e-12);
      // The first hit of a ray from outside faces it, that of one from inside does not.
      const bool from_inside = truth.starts_inside && !(border && !eye_within);
      inward += (hit->normal.dot(ray.direction) > 1e-9) != from_inside &&
                std::abs(hit->normal.dot(ray.direction)) > 1e-9;
      if (border || truth.gradient.norm() < 1e-3) continue;
      const Vec3 normal = -(grid.geometry.world_to_index_matrix().transpose() * truth.gradient).normalized();
      off += !((hit->normal - normal).norm() < 1e-6);
    }
  }
  std::printf(
      "rays %lld, judged %lld, hits %lld: wrong %lld, misplaced %lld, zero normals %lld, inward %lld, off "
      "%lld\n",
      static_cast<long long>(rays), static_cast<long long>(judged), static_cast<long long>(hits),
      static_cast<long long>(wrong), static_cast<long long>(misplaced), static_cast<long long>(zero),
      static_cast<long long>(inward), static_cast<long long>(off));
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(misplaced, 0);
  EXPECT_EQ(zero, 0);
  EXPECT_EQ(inward, 0);
  EXPECT_EQ(off, 0);
  EXPECT_GT(judged, rays * 9 / 10);
  EXPECT_GT(within, 1000);
  EXPECT_GT(hits, rays / 3);
}

// A block of the maximum in zeros, seen along all six axis directions: the faces lie on planes of samples,
// and their normals are the faces'.
TEST(IsosurfaceRays, MasksAtTheirMaximumHaveNormals) {
  volume::Grid<std::uint8_t> mask;
  mask.geometry.dims = {12, 11, 13};
  mask.geometry.spacing = {0.5, 1, 2};
  mask.voxels = Buffer<std::uint8_t>(static_cast<std::size_t>(mask.geometry.count()));
  std::fill(mask.voxels.begin(), mask.voxels.end(), std::uint8_t{0});
  for (std::int64_t k = 3; k < 9; ++k) {
    for (std::int64_t j = 3; j < 8; ++j) {
      for (std::int64_t i = 3; i < 8; ++i) mask(i, j, k) = 255;
    }
  }
  volume::Volume volume;
  volume.grid = std::move(mask);
  const auto& geometry = volume.geometry();
  for (const auto kernel : {volume::Reconstruction::trilinear, volume::Reconstruction::catmull_rom}) {
    const IsosurfaceRays surface(volume, kernel, 255, false);
    const RayBox box(surface.bounds());
    IsosurfaceRays::Counts counts;
    for (int side = 0; side < 6; ++side) {
      const int axis = side % 3;
      const Vec3 d = (side < 3 ? 1 : -1) * Vec3::Unit(axis);
      for (int n = 0; n < 25; ++n) {
        // On samples and between them, two cells from the block's edges in the case of the cubic.
        Vec3 x = 4 + 0.5 * Eigen::Array3d(n % 5, n / 5 % 5, n % 5);
        x[axis] = side < 3 ? -5 : 20;
        const camera::Ray ray{geometry.index_to_world(x), d};
        const auto chord = box.chord(ray, 0);
        ASSERT_TRUE(chord);
        const auto hit = surface.first_hit(ray, *chord, counts);
        ASSERT_TRUE(hit) << side << " " << n;
        EXPECT_NEAR(hit->normal.norm(), 1, 1e-12) << side << " " << n;
        EXPECT_LT(hit->normal.dot(d), 0) << side << " " << n;
        if (kernel == volume::Reconstruction::trilinear) {
          EXPECT_NEAR(hit->normal.dot(d), -1, 1e-12) << side << " " << n;
        }
      }
    }
  }
}

// The eye within a closed volume that is all inside sees its border from within, where the chord ends.
TEST(IsosurfaceRays, AClosedBorderFromWithin) {
  const volume::Volume volume = constant(7, true, {6, 5, 7});
  const IsosurfaceRays surface(volume, volume::Reconstruction::trilinear, 7, true);
  const RayBox box(surface.bounds());
  Rng rng(98);
  IsosurfaceRays::Counts counts;
  for (int n = 0; n < 100; ++n) {
    camera::Ray ray = random_ray(rng, surface.bounds());
    ray.origin = surface.bounds().centre();
    const auto chord = box.chord(ray, 0);
    ASSERT_TRUE(chord);
    const auto hit = surface.first_hit(ray, *chord, counts);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->t, chord->exit);
    EXPECT_GT(hit->normal.dot(ray.direction), 0);
  }
}

}  // namespace
}  // namespace vol::render
