#include "features/local_energy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "wavelet/filters.h"

namespace vol::features {
namespace {

/// Along one axis: the coefficients from `first` on whose centres lie over the volume, and their positions.
struct Axis {
  std::int64_t first = 0, count = 1;
  double position = 0;  // of the first, voxels
  double step = 1;
};

Axis axis_of(std::int64_t voxels, std::int64_t extended, std::int64_t lower, std::int64_t count, int level,
             double centre) {
  Axis a;
  if (extended == 1) return a;
  a.step = std::ldexp(1.0, level);
  // Centres within the voxels' own boxes, [-1/2, n - 1/2].
  const double n = static_cast<double>(voxels);
  std::int64_t from = static_cast<std::int64_t>(std::ceil((-0.5 - centre) / a.step));
  std::int64_t to = static_cast<std::int64_t>(std::floor((n - 0.5 - centre) / a.step));
  from = std::clamp(from, lower, lower + count - 1);
  to = std::clamp(to, from, lower + count - 1);
  a.first = from - lower;
  a.count = to - from + 1;
  a.position = a.step * static_cast<double>(from) + centre;
  return a;
}

/// Weights at the distances 0, 1, ... of coefficients, to three standard deviations, on an axis of n.
std::vector<float> gaussian(double sigma, std::int64_t n) {
  const auto reach = static_cast<std::int64_t>(std::min(std::ceil(3 * sigma), static_cast<double>(n - 1)));
  std::vector<float> weights;
  for (std::int64_t t = 0; t <= reach; ++t) {
    const double x = static_cast<double>(t) / sigma;
    weights.push_back(static_cast<float>(std::exp(-0.5 * x * x)));
  }
  return weights;
}

/// The weighted mean over a window along an axis; weights beyond the ends are left out and the rest makes up
/// for them. Samples at the same distance are added first: the mean of a mirrored row is the mirrored mean,
/// to the last bit.
void smooth(Buffer<float>& values, const Dims& dims, int axis, const std::vector<float>& weights) {
  const std::int64_t n = dims[axis];
  if (n < 2 || weights.size() < 2) return;
  std::int64_t stride = 1;
  for (int a = 0; a < axis; ++a) stride *= dims[a];
  const std::int64_t lines = dims[0] * dims[1] * dims[2] / n;
  // Lines side by side are smoothed together, as rows of `width` numbers.
  const std::int64_t width = std::min<std::int64_t>(stride, 64);
  const std::int64_t groups = lines / stride * ((stride + width - 1) / width);
  const std::int64_t along = (stride + width - 1) / width;
  parallel_for(0, groups, std::max<std::int64_t>(1, 4096 / (n * width)),
               [&](std::int64_t begin, std::int64_t end) {
                 std::vector<float> out(static_cast<std::size_t>(n * width));
                 for (std::int64_t group = begin; group < end; ++group) {
                   const std::int64_t left = group % along * width;
                   const std::int64_t wide = std::min(width, stride - left);
                   float* const base = values.data() + group / along * stride * n + left;
                   for (std::int64_t i = 0; i < n; ++i) {
                     float* const to = out.data() + i * width;
                     const float* const at = base + i * stride;
                     for (std::int64_t x = 0; x < wide; ++x) to[x] = weights[0] * at[x];
                     float total = weights[0];
                     for (std::int64_t t = 1; t < std::ssize(weights); ++t) {
                       const float w = weights[static_cast<std::size_t>(t)];
                       const bool before = i - t >= 0, after = i + t < n;
                       const float* const lo = at - t * stride;
                       const float* const hi = at + t * stride;
                       if (before && after) {
                         for (std::int64_t x = 0; x < wide; ++x) to[x] += w * (lo[x] + hi[x]);
                       } else if (before || after) {
                         const float* const one = before ? lo : hi;
                         for (std::int64_t x = 0; x < wide; ++x) to[x] += w * one[x];
                       }
                       total += w * static_cast<float>(before + after);
                     }
                     for (std::int64_t x = 0; x < wide; ++x) to[x] /= total;
                   }
                   for (std::int64_t i = 0; i < n; ++i) {
                     std::copy_n(out.data() + i * width, wide, base + i * stride);
                   }
                 }
               });
}

}  // namespace

double coefficient_centre(const std::string& wavelet, int levels, bool high_pass) {
  if (levels == 0) return 0;
  const wavelet::FilterBank bank = wavelet::make_wavelet(wavelet).bank;
  // Of s steps: f_s[p] = sum_n f[n] h_(s-1)[p - 2^(s-1) n].
  std::vector<double> taps{1};
  double first = 0, spread = 1;
  for (int s = 1; s <= levels; ++s) {
    const auto& f = s == levels && high_pass ? bank.g : bank.h;
    const auto distance = static_cast<std::size_t>(spread);
    std::vector<double> next(taps.size() + distance * (f.size() - 1), 0.0);
    for (std::size_t n = 0; n < f.size(); ++n) {
      for (std::size_t p = 0; p < taps.size(); ++p) next[p + distance * n] += f[n] * taps[p];
    }
    first += spread * static_cast<double>(bank.first);
    spread *= 2;
    taps = std::move(next);
  }
  double mass = 0, moment = 0;
  for (std::size_t p = 0; p < taps.size(); ++p) {
    mass += taps[p] * taps[p];
    moment += taps[p] * taps[p] * static_cast<double>(p);
  }
  return first + moment / mass;
}

template <class T>
FeatureField::Grid FeatureField::smoothed(const wavelet::Decomposition<T>& d, wavelet::Subband<T>& band,
                                          double window) const {
  Grid grid;
  grid.is_detail = band.orientation != 0;
  std::array<Axis, 3> axes;
  int transformed = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool high_pass = band.orientation >> a & 1;
    const double centre = d.extended_dims[a] > 1 ? coefficient_centre(d.wavelet, band.level, high_pass) : 0;
    axes[a] =
        axis_of(d.geometry.dims[a], d.extended_dims[a], band.lower[a], band.dims[a], band.level, centre);
    grid.dims[a] = axes[a].count;
    transformed += d.extended_dims[a] > 1;
  }
  const double weight = std::exp2(-0.5 * transformed * band.level) / unit_;
  grid.values = Buffer<float>(static_cast<std::size_t>(grid.dims[0] * grid.dims[1] * grid.dims[2]));
  const double centre = offset_ / unit_;
  parallel_for(0, grid.dims[1] * grid.dims[2], 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      const std::int64_t j = axes[1].first + row % grid.dims[1], k = axes[2].first + row / grid.dims[1];
      const T* const from = band.coefficients.data() + axes[0].first + band.dims[0] * (j + band.dims[1] * k);
      float* const to = grid.values.data() + grid.dims[0] * row;
      for (std::int64_t i = 0; i < grid.dims[0]; ++i) {
        const double c = weight * static_cast<double>(from[i]);
        const double value = !grid.is_detail ? c - centre : std::abs(c) < least_ ? 0 : c * c;
        to[i] = static_cast<float>(value);
        if (!std::isfinite(to[i]))
          throw Error("coefficients hold a number that is not finite, or too large for their range");
      }
    }
  });
  band.coefficients = {};
  for (int a = 0; a < 3; ++a) {
    const double sigma = window / axes[static_cast<std::size_t>(a)].step;
    // A window far narrower than the distance of the coefficients leaves them as they are.
    if (sigma > 0.2) smooth(grid.values, grid.dims, a, gaussian(sigma, grid.dims[a]));
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::int64_t x = 0; x < d.geometry.dims[a]; ++x) {
      const double last = static_cast<double>(axes[a].count - 1);
      const double t = std::clamp((static_cast<double>(x) - axes[a].position) / axes[a].step, 0.0, last);
      const double below = std::floor(t);
      Tap tap;
      tap.first = static_cast<std::int32_t>(below);
      tap.second = static_cast<std::int32_t>(std::min(below + 1, last));
      tap.weight = static_cast<float>(t - below);
      grid.taps[a].push_back(tap);
    }
  }
  return grid;
}

template <class T>
FeatureField::FeatureField(wavelet::Decomposition<T>&& d, const FeatureOptions& options)
    : geometry_(d.geometry) {
  if (!(options.window >= 0 && std::isfinite(options.window)))
    throw Error("window: a width of at least 0 voxels is expected");
  const double most = std::max(std::abs(d.range.min), std::abs(d.range.max));
  if (!std::isfinite(most)) throw Error("coefficients of a volume without a finite range");
  unit_ = most > 0 ? std::ldexp(1.0, std::ilogb(most)) : 1;
  offset_ = d.range.min / 2 + d.range.max / 2;
  least_ = 8 * static_cast<double>(std::numeric_limits<float>::epsilon()) / 2 * most / unit_;
  for (auto& band : d.subbands) {
    if (band.orientation == 0 && !options.approximation) continue;
    names_.push_back("level" + std::to_string(band.level) + "." +
                     wavelet::orientation_name(band.orientation));
    grids_.push_back(smoothed(d, band, options.window));
  }
  if (grids_.empty())
    throw Error("coefficients of 0 levels have no detail: without the approximation there are no features");
}

namespace {

float between(float a, float b, float weight) {
  return (1 - weight) * a + weight * b;
}

}  // namespace

void FeatureField::at(std::int64_t i, std::int64_t j, std::int64_t k, std::span<float> values) const {
  for (std::size_t f = 0; f < grids_.size(); ++f) {
    const Grid& g = grids_[f];
    const Tap &x = g.taps[0][static_cast<std::size_t>(i)], &y = g.taps[1][static_cast<std::size_t>(j)],
              &z = g.taps[2][static_cast<std::size_t>(k)];
    const auto column = [&](std::int64_t at) {
      const auto value = [&](std::int64_t b, std::int64_t c) {
        return g.values[static_cast<std::size_t>(at + g.dims[0] * (b + g.dims[1] * c))];
      };
      return between(between(value(y.first, z.first), value(y.second, z.first), y.weight),
                     between(value(y.first, z.second), value(y.second, z.second), y.weight), z.weight);
    };
    const float value = between(column(x.first), column(x.second), x.weight);
    values[f] = g.is_detail ? std::sqrt(value) : value;
  }
}

void FeatureField::row(std::int64_t j, std::int64_t k, std::span<float> values) const {
  std::vector<float> coarse;
  const std::int64_t nx = geometry_.dims[0];
  for (std::size_t f = 0; f < grids_.size(); ++f) {
    const Grid& g = grids_[f];
    const Tap &y = g.taps[1][static_cast<std::size_t>(j)], &z = g.taps[2][static_cast<std::size_t>(k)];
    const auto line = [&](std::int64_t b, std::int64_t c) {
      return g.values.data() + g.dims[0] * (b + g.dims[1] * c);
    };
    const float *const a = line(y.first, z.first), *const b = line(y.second, z.first),
                       *const c = line(y.first, z.second), *const d = line(y.second, z.second);
    coarse.resize(static_cast<std::size_t>(g.dims[0]));
    for (std::size_t i = 0; i < coarse.size(); ++i) {
      coarse[i] = between(between(a[i], b[i], y.weight), between(c[i], d[i], y.weight), z.weight);
    }
    float* const to = values.data() + static_cast<std::int64_t>(f) * nx;
    for (std::int64_t i = 0; i < nx; ++i) {
      const Tap& x = g.taps[0][static_cast<std::size_t>(i)];
      to[i] = between(coarse[static_cast<std::size_t>(x.first)], coarse[static_cast<std::size_t>(x.second)],
                      x.weight);
    }
    if (!g.is_detail) continue;
    for (std::int64_t i = 0; i < nx; ++i) to[i] = std::sqrt(to[i]);
  }
}

template FeatureField::FeatureField(wavelet::Decomposition<float>&&, const FeatureOptions&);
template FeatureField::FeatureField(wavelet::Decomposition<double>&&, const FeatureOptions&);

}  // namespace vol::features
