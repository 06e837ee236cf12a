#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "base/rng.h"
#include "features/local_energy.h"
#include "textures.h"

namespace vol::features {
namespace {

volume::Volume random_volume(const Dims& dims, std::uint64_t seed) {
  volume::GridGeometry geometry;
  geometry.dims = dims;
  volume::Volume volume = volume::allocate(volume::VoxelType::f32, geometry);
  Rng rng(seed);
  for (auto& v : std::get<volume::Grid<float>>(volume.grid).voxels)
    v = static_cast<float>(rng.uniform(-1, 2));
  return volume;
}

// An impulse at x has the coefficients f[x - 2^m k]. So over all places of the impulse the mean of p_k - x,
// weighed by the squares of the coefficients, is 0 where p_k is the filter's centre of gravity. By the
// transform itself.
TEST(CoefficientCentre, IsWhereTheTransformPutsAnImpulse) {
  for (const char* name : {"haar", "daubechies-4", "daubechies-12", "coiflet-6", "coiflet-18"}) {
    for (int level = 1; level <= 3; ++level) {
      for (const bool high : {false, true}) {
        if (!high && level < 3) continue;  // only the last has an approximation
        double mass = 0, moment = 0;
        for (std::int64_t x = 0; x < 8; ++x) {
          volume::GridGeometry geometry;
          geometry.dims = {512, 1, 1};
          volume::Volume volume = volume::allocate(volume::VoxelType::f64, geometry);
          auto& voxels = std::get<volume::Grid<double>>(volume.grid).voxels;
          std::fill(voxels.begin(), voxels.end(), 0.0);
          voxels[static_cast<std::size_t>(250 + x)] = 1;
          const auto d = wavelet::analyze<double>(volume, {.wavelet = name, .levels = 3}, {0, 1});
          for (const auto& band : d.subbands) {
            if (band.level != level || (band.orientation != 0) != high) continue;
            for (std::size_t k = 0; k < band.coefficients.size(); ++k) {
              const double square = band.coefficients[k] * band.coefficients[k];
              const double p =
                  std::ldexp(static_cast<double>(k), level) + coefficient_centre(name, level, high);
              mass += square;
              moment += square * (p - static_cast<double>(250 + x));
            }
          }
        }
        EXPECT_NEAR(moment / mass, 0, 1e-9) << name << " level " << level << (high ? " high" : " low");
      }
    }
  }
  EXPECT_NEAR(coefficient_centre("haar", 3, true), 3.5, 1e-12);
  EXPECT_NEAR(coefficient_centre("battle-lemarie-3", 2, false), 0, 1e-9);  // symmetric about 0
}

// The definition, in double, at every place of a subband: sums at the coefficients, linear between, then the
// root.
TEST(FeatureField, IsItsDefinition) {
  const Dims dims{19, 11, 16};
  const double sigma = 1.7;
  const volume::Volume volume = random_volume(dims, 4);
  const auto d = transformed(volume, "haar", 2);
  const FeatureField field(transformed(volume, "haar", 2), {.window = sigma});
  ASSERT_EQ(field.size(), 15);
  const auto weight = [&](double distance) {
    return distance <= 3 * sigma + 4 ? std::exp(-0.5 * distance * distance / (sigma * sigma)) : 0;
  };
  Rng rng(9);
  for (int f = 0; f < field.size(); ++f) {
    const auto& band = d.subbands[static_cast<std::size_t>(f)];
    ASSERT_EQ(field.names()[static_cast<std::size_t>(f)],
              "level" + std::to_string(band.level) + "." + wavelet::orientation_name(band.orientation));
    const double step = std::ldexp(1.0, band.level), centre = (step - 1) / 2;
    Dims inside;  // coefficients whose centres lie over the volume
    for (std::size_t a = 0; a < 3; ++a) {
      inside[a] = std::min(
          band.dims[a],
          static_cast<std::int64_t>(std::floor((static_cast<double>(dims[a]) - 0.5 - centre) / step)) + 1);
    }
    const auto sum_at = [&](const Dims& at) {
      const auto reach = static_cast<std::int64_t>(std::ceil(3 * sigma / step));
      double sum = 0, total = 0;
      Dims k;
      for (k[2] = 0; k[2] < inside[2]; ++k[2]) {
        for (k[1] = 0; k[1] < inside[1]; ++k[1]) {
          for (k[0] = 0; k[0] < inside[0]; ++k[0]) {
            double w = 1;
            for (std::size_t a = 0; a < 3; ++a) {
              const auto far = std::abs(k[a] - at[a]);
              w *= far <= reach ? weight(step * static_cast<double>(far)) : 0;
            }
            const double c = band.coefficients[static_cast<std::size_t>(
                                 k[0] + band.dims[0] * (k[1] + band.dims[1] * k[2]))] /
                             std::exp2(1.5 * band.level);
            sum += w * (band.orientation != 0 ? c * c : c);
            total += w;
          }
        }
      }
      return sum / total;
    };
    for (int n = 0; n < 12; ++n) {
      const Dims voxel{static_cast<std::int64_t>(rng.below(19)), static_cast<std::int64_t>(rng.below(11)),
                       static_cast<std::int64_t>(rng.below(16))};
      double expected = 0;
      for (int corner = 0; corner < 8; ++corner) {
        double w = 1;
        Dims at;
        for (std::size_t a = 0; a < 3; ++a) {
          const double t = std::clamp((static_cast<double>(voxel[a]) - centre) / step, 0.0,
                                      static_cast<double>(inside[a] - 1));
          const auto below = static_cast<std::int64_t>(t);
          const double fraction = t - static_cast<double>(below);
          at[a] = std::min(below + (corner >> a & 1), inside[a] - 1);
          w *= corner >> a & 1 ? fraction : 1 - fraction;
        }
        if (w > 0) expected += w * sum_at(at);
      }
      if (band.orientation != 0) expected = std::sqrt(expected);
      std::vector<float> values(15);
      field.at(voxel[0], voxel[1], voxel[2], values);
      // Sums of some hundred floats of one sign.
      EXPECT_NEAR(values[static_cast<std::size_t>(f)] * field.unit() + field.offset(f), expected, 2e-6)
          << field.names()[static_cast<std::size_t>(f)];
    }
  }
}

TEST(FeatureField, RowsHoldTheVoxels) {
  for (const char* name : {"haar", "daubechies-6", "battle-lemarie-1"}) {
    const FeatureField field(transformed(random_volume({21, 13, 10}, 2), name, 2), {.window = 2});
    std::vector<float> row(15 * 21), values(15);
    for (std::int64_t k = 0; k < 10; k += 3) {
      field.row(5, k, row);
      for (std::int64_t i = 0; i < 21; ++i) {
        field.at(i, 5, k, values);
        for (std::size_t f = 0; f < 15; ++f) EXPECT_EQ(row[f * 21 + static_cast<std::size_t>(i)], values[f]);
      }
    }
  }
}

// White noise of variance s^2 has coefficients of the same variance in an orthonormal transform: an amplitude
// of s 2^(-3m/2) at level m. The window holds (2 sigma sqrt(pi) / 2^m)^3 independent squares, 700 at level 1,
// and the mean over the volume some hundred windows: 2 % is five standard deviations of the worst.
TEST(FeatureField, AmplitudesOfWhiteNoise) {
  const FeatureField field(transformed(random_volume({64, 64, 64}, 8), "daubechies-4", 2), {.window = 5});
  const double deviation = 3 / std::sqrt(12.0);
  std::vector<double> mean(15, 0);
  std::vector<float> values(15);
  for (std::int64_t n = 0; n < 4096; ++n) {
    field.at(n % 16 * 4, n / 16 % 16 * 4, n / 256 * 4, values);
    for (std::size_t f = 0; f < 15; ++f) mean[f] += values[f] * field.unit() / 4096;
  }
  for (std::size_t f = 0; f < 15; ++f) {
    if (field.names()[f].ends_with("LLL")) continue;
    const int level = field.names()[f][5] - '0';
    EXPECT_NEAR(mean[f] / (deviation * std::exp2(-1.5 * level)), 1, level == 1 ? 0.02 : 0.04)
        << field.names()[f];
  }
}

// Of Haar a mirrored volume has mirrored coefficients, to the last bit; so have the features.
TEST(FeatureField, MirrorsWithTheVolume) {
  const Dims dims{24, 16, 40};
  const volume::Volume volume = random_volume(dims, 11);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    volume::Volume mirrored = volume;
    const auto& from = std::get<volume::Grid<float>>(volume.grid);
    auto& to = std::get<volume::Grid<float>>(mirrored.grid);
    const auto place = [&](std::int64_t v) {
      std::array<std::int64_t, 3> p{v % dims[0], v / dims[0] % dims[1], v / dims[0] / dims[1]};
      p[axis] = dims[axis] - 1 - p[axis];
      return p;
    };
    for (std::int64_t v = 0; v < 24 * 16 * 40; ++v) {
      const auto p = place(v);
      to.voxels[static_cast<std::size_t>(v)] = from(p[0], p[1], p[2]);
    }
    const FeatureField a(transformed(volume, "haar"), {.window = 3}),
        b(transformed(mirrored, "haar"), {.window = 3});
    std::vector<float> x(22), y(22);
    for (std::int64_t v = 0; v < 24 * 16 * 40; v += 7) {
      const auto p = place(v);
      a.at(p[0], p[1], p[2], x);
      b.at(v % dims[0], v / dims[0] % dims[1], v / dims[0] / dims[1], y);
      ASSERT_EQ(x, y) << "axis " << axis << " voxel " << v;
    }
  }
}

TEST(FeatureField, SameForAnyNumberOfThreads) {
  const volume::Volume volume = random_volume({40, 33, 27}, 1);
  std::vector<float> one(22 * 40), three(22 * 40);
  set_thread_count(1);
  FeatureField(transformed(volume, "coiflet-6"), {}).row(20, 11, one);
  set_thread_count(3);
  FeatureField(transformed(volume, "coiflet-6"), {}).row(20, 11, three);
  set_thread_count(0);
  EXPECT_EQ(one, three);
}

TEST(FeatureField, ExtremesAndRefusals) {
  // Flat axes, axes shorter than the extension, no levels.
  EXPECT_EQ(FeatureField(transformed(random_volume({9, 1, 30}, 1), "haar", 2), {}).size(), 7);
  EXPECT_EQ(FeatureField(transformed(random_volume({1, 1, 5}, 1), "haar", 1), {}).size(), 2);
  EXPECT_EQ(FeatureField(transformed(random_volume({3, 2, 5}, 1), "daubechies-4", 2), {}).size(), 15);
  EXPECT_EQ(FeatureField(transformed(random_volume({3, 2, 5}, 1), "haar", 0), {}).names().front(),
            "level0.LLL");
  EXPECT_THROW(FeatureField(transformed(random_volume({3, 2, 5}, 1), "haar", 0), {.approximation = false}),
               Error);
  EXPECT_THROW(FeatureField(transformed(random_volume({3, 2, 5}, 1), "haar", 1), {.window = -1}), Error);
  auto bad = transformed(random_volume({8, 8, 8}, 1), "haar", 1);
  bad.subbands[3].coefficients[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(FeatureField(std::move(bad), {}), Error);
  // Rounding is no texture: a constant that float does not hold exactly, through long filters.
  volume::Volume flat = random_volume({16, 16, 16}, 1);
  for (auto& v : std::get<volume::Grid<float>>(flat.grid).voxels) v = 0.1F;
  const FeatureField field(transformed(flat, "coiflet-18", 2), {});
  std::vector<float> values(15);
  field.at(7, 8, 9, values);
  for (std::size_t f = 1; f < 15; ++f) EXPECT_EQ(values[f], 0) << field.names()[f];
  // Values of 1e30 and 1e-30 are those of 1, on another scale.
  for (const float scale : {1e30F, 1e-30F}) {
    volume::Volume scaled = random_volume({16, 16, 16}, 3);
    for (auto& v : std::get<volume::Grid<float>>(scaled.grid).voxels) v *= scale;
    const FeatureField large(transformed(scaled, "haar", 2), {}),
        usual(transformed(random_volume({16, 16, 16}, 3), "haar", 2), {});
    std::vector<float> x(15), y(15);
    large.at(3, 4, 5, x);
    usual.at(3, 4, 5, y);
    for (std::size_t f = 0; f < 15; ++f)
      EXPECT_NEAR(x[f] * large.unit() / scale, y[f] * usual.unit(), 1e-6) << f;
  }
}

}  // namespace
}  // namespace vol::features
