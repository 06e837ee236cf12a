// texture: regions that differ in nothing but texture.
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/parallel.h"
#include "base/rng.h"
#include "volume/analytic_form.h"
#include "volume/analytic_texture.h"

namespace vol::volume {
namespace {

constexpr double kPi = std::numbers::pi;

/// What the waves of a region have in common.
struct Band {
  double lowest, highest;  // cycles an edge
  int axis;                // -1: waves in all directions
};
// Two bands an octave apart, and in the higher one two directions against all of them.
constexpr std::array<Band, kTextureRegions> kBands{{{9, 14, -1}, {20, 28, -1}, {20, 28, 0}, {20, 28, 2}}};
constexpr double kCone = 25 * kPi / 180;  // half opening angle about the axis

int region_at(const Vec3& p) {
  static const Vec3 kFirst(1, 0.35, -0.2), kSecond(-0.3, 1, 0.25);
  return (kFirst.dot(p) >= 0 ? 1 : 0) + (kSecond.dot(p) >= 0 ? 2 : 0);
}

/// 1/2 + a sum of kWaves cosines of one amplitude, other waves in each region: wave vectors uniform in the
/// region's shell of frequencies (in its cone), phases uniform. All regions have the mean 1/2, the variance
/// kWaves a^2 / 2 = 1/64 and, each voxel being a sum of as many independent cosines, the same distribution.
class Texture : public AnalyticForm {
 public:
  explicit Texture(std::uint64_t seed) {
    Rng rng(seed);
    for (std::size_t r = 0; r < kBands.size(); ++r) {
      for (auto& wave : waves_[r]) wave = {drawn(kBands[r], rng), rng.uniform(0, 2 * kPi)};
    }
  }
  double value(const Vec3& p) const override {
    double sum = 0;
    for (const auto& wave : waves(p)) sum += std::cos(wave.k.dot(p) + wave.phase);
    return 0.5 + kAmplitude * sum;
  }
  Vec3 gradient(const Vec3& p) const override {
    Vec3 sum = Vec3::Zero();
    for (const auto& wave : waves(p)) sum -= std::sin(wave.k.dot(p) + wave.phase) * wave.k;
    return kAmplitude * sum;
  }

 private:
  static constexpr std::size_t kWaves = 32;
  const double kAmplitude = std::sqrt(2.0 / kWaves) / 8;
  struct Wave {
    Vec3 k;  // radians per canonical unit
    double phase;
  };
  using Waves = std::array<Wave, kWaves>;

  static Vec3 drawn(const Band& band, Rng& rng) {
    for (;;) {
      const Vec3 k = band.highest * Vec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const double f = k.norm();
      if (f > band.highest || f < band.lowest) continue;
      if (band.axis >= 0 && std::abs(k[band.axis]) < f * std::cos(kCone)) continue;
      return kPi * k;  // an edge is two units
    }
  }
  [[nodiscard]] const Waves& waves(const Vec3& p) const {
    return waves_[static_cast<std::size_t>(region_at(p))];
  }

  std::array<Waves, kTextureRegions> waves_;
};

}  // namespace

FormPointer make_texture_form(std::string_view name, const AnalyticOptions& options) {
  if (name == "texture") return std::make_shared<Texture>(options.seed);
  return nullptr;
}

int texture_region(const Vec3& p_canonical) {
  return region_at(p_canonical);
}

Volume texture_labels(const GridGeometry& geometry) {
  Volume volume = allocate(VoxelType::u8, geometry);
  auto& grid = std::get<Grid<std::uint8_t>>(volume.grid);
  const auto [nx, ny, nz] = geometry.dims;
  parallel_for(0, ny * nz, 16, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t row = first; row < last; ++row) {
      for (std::int64_t i = 0; i < nx; ++i) {
        const Vec3 p(canonical_coordinate(i, nx), canonical_coordinate(row % ny, ny),
                     canonical_coordinate(row / ny, nz));
        grid.voxels[static_cast<std::size_t>(i + nx * row)] = static_cast<std::uint8_t>(region_at(p));
      }
    }
  });
  return volume;
}

}  // namespace vol::volume
