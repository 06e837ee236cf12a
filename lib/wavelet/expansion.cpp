#include "wavelet/expansion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "volume/grid_sampler.h"
#include "wavelet/layout.h"

namespace vol::wavelet {
namespace {

/// 21 bits of x, each followed by two zeros.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffffULL;
  x = (x | x << 16) & 0x1f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  return (x | x << 2) & 0x1249249249249249ULL;
}

void sort_and_build(Band& band) {
  std::array<std::int32_t, 3> least;
  least.fill(std::numeric_limits<std::int32_t>::max());
  for (const Term& t : band.terms) {
    for (std::size_t a = 0; a < 3; ++a) least[a] = std::min(least[a], t.k[a]);
  }
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  for (const Term& t : band.terms) {
    std::uint64_t key = 0;
    for (std::size_t a = 0; a < 3; ++a) key |= spread(static_cast<std::uint64_t>(t.k[a] - least[a])) << a;
    order.emplace_back(key, order.size());
  }
  std::sort(order.begin(), order.end());
  std::vector<Term> sorted;
  for (const auto& [key, i] : order) sorted.push_back(band.terms[i]);
  band.terms = std::move(sorted);

  const auto group = [](auto first, auto last) {
    Band::Node node = *first;
    for (; first != last; ++first) {
      for (std::size_t a = 0; a < 3; ++a) {
        node.lower[a] = std::min(node.lower[a], first->lower[a]);
        node.upper[a] = std::max(node.upper[a], first->upper[a]);
      }
    }
    return node;
  };
  std::vector<Band::Node> below;
  for (const Term& t : band.terms) below.push_back({t.k, t.k});
  while (band.nodes.empty() || below.size() > 1) {
    std::vector<Band::Node> above;
    for (std::size_t i = 0; i < below.size(); i += Band::kFanout) {
      const std::size_t end = std::min(below.size(), i + Band::kFanout);
      above.push_back(group(below.begin() + static_cast<std::ptrdiff_t>(i),
                            below.begin() + static_cast<std::ptrdiff_t>(end)));
    }
    band.nodes.push_back(above);
    below = std::move(above);
  }
}

/// First and last j for which coefficient k + j period meets [0, last] on an axis.
struct Images {
  std::int64_t first, last;
};
Images images(const Band& band, int axis, std::int64_t k, std::int64_t period, double last) {
  // scale (k + j period + lower) - shift <= last,  scale (k + j period + upper) - shift > 0.
  const double low = (last + band.shift[axis]) / band.scale[axis] - band.lower[axis];
  const double high = band.shift[axis] / band.scale[axis] - band.upper[axis];
  const auto p = static_cast<double>(period), at = static_cast<double>(k);
  return {static_cast<std::int64_t>(std::floor((high - at) / p)) + 1,
          static_cast<std::int64_t>(std::floor((low - at) / p))};
}

template <class T>
void add_terms(const Subband<T>& subband, const Dims& extended, const Box3& box, Band& band,
               std::int64_t& coefficients) {
  std::array<std::int64_t, 3> period{};
  for (std::size_t a = 0; a < 3; ++a) period[a] = extended[a] == 1 ? 1 : extended[a] >> band.level;
  const auto axis_images = [&](int axis, std::int64_t k) {
    const auto a = static_cast<std::size_t>(axis);
    return extended[a] == 1 ? Images{0, 0} : images(band, axis, k, period[a], box.max[axis]);
  };
  std::size_t at = 0;
  for (std::int64_t k = 0; k < subband.dims[2]; ++k) {
    const Images z = axis_images(2, k);
    for (std::int64_t j = 0; j < subband.dims[1]; ++j) {
      const Images y = axis_images(1, j);
      for (std::int64_t i = 0; i < subband.dims[0]; ++i, ++at) {
        const auto c = static_cast<double>(subband.coefficients[at]);
        if (c == 0) continue;
        ++coefficients;
        const Images x = axis_images(0, i);
        for (std::int64_t w = z.first; w <= z.last; ++w) {
          for (std::int64_t v = y.first; v <= y.last; ++v) {
            for (std::int64_t u = x.first; u <= x.last; ++u) {
              band.terms.push_back({c * band.weight,
                                    {static_cast<std::int32_t>(i + u * period[0]),
                                     static_cast<std::int32_t>(j + v * period[1]),
                                     static_cast<std::int32_t>(k + w * period[2])}});
            }
          }
        }
      }
    }
  }
}

}  // namespace

Box3 Band::box(const Node& node) const {
  Box3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    result.min[a] = scale[a] * (node.lower[i] + lower[a]) - shift[a];
    result.max[a] = scale[a] * (node.upper[i] + upper[a]) - shift[a];
  }
  return result;
}

template <class T>
Expansion::Expansion(const Decomposition<T>& decomposition, const ExpansionOptions& options)
    : geometry_(decomposition.geometry),
      bounds_(volume::field_bounds(geometry_)),
      box_(geometry_.index_box()),
      world_to_index_(geometry_.world_to_index_matrix()) {
  validate(decomposition);
  if (decomposition.boundary != Boundary::periodic) {
    throw Error(
        "coefficients with a symmetric boundary: a continuous field is known only for --boundary "
        "periodic; transform anew");
  }
  const Dims& extended = decomposition.extended_dims;
  for (const std::int64_t n : extended) {
    if (n >= std::int64_t{1} << 30) {
      throw Error("an axis of " + std::to_string(n) + " samples: expected fewer than 2^30");
    }
  }
  const Wavelet wavelet = make_wavelet(decomposition.wavelet);
  const Prototypes prototypes = make_prototypes(wavelet, options.depth);
  phi_deviation_ = prototypes.phi_deviation;
  psi_deviation_ = prototypes.psi_deviation;
  functions_.push_back({-1, 2, {{1, 0, 0, 0}}});  // along an axis of one sample
  for (const auto& subband : decomposition.subbands) {
    Band band;
    band.level = subband.level;
    band.orientation = subband.orientation;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      if (extended[i] > 1) {
        const bool detail = (subband.orientation >> i & 1) != 0;
        const PiecewiseCubic f =
            periodised(detail ? prototypes.psi : prototypes.phi, extended[i] >> subband.level);
        const auto same = std::find_if(functions_.begin(), functions_.end(), [&](const auto& g) {
          return g.lower == f.lower && g.spacing == f.spacing && g.pieces == f.pieces;
        });
        band.factor[i] = static_cast<int>(same - functions_.begin());
        if (same == functions_.end()) functions_.push_back(f);
        band.scale[a] = std::ldexp(1.0, subband.level);
        band.shift[a] = wavelet.mean;
        band.weight /= std::sqrt(band.scale[a]);
      }
      band.lower[a] = function(band.factor[i]).lower;
      band.upper[a] = function(band.factor[i]).upper();
    }
    add_terms(subband, extended, box_, band, coefficients_);
    if (band.terms.empty()) continue;
    sort_and_build(band);
    bands_.push_back(std::move(band));
  }
}

template Expansion::Expansion(const Decomposition<float>&, const ExpansionOptions&);
template Expansion::Expansion(const Decomposition<double>&, const ExpansionOptions&);

double Expansion::value(const Vec3& p_world) const {
  const Vec3 p = world_to_index_ * (p_world - geometry_.origin);
  return value_index(p.cwiseMax(box_.min).cwiseMin(box_.max));
}

Vec3 Expansion::gradient(const Vec3& p_world) const {
  const Vec3 p = world_to_index_ * (p_world - geometry_.origin);
  return world_to_index_.transpose() * gradient_index(p.cwiseMax(box_.min).cwiseMin(box_.max));
}

double Expansion::value_index(const Vec3& p) const {
  double sum = 0;
  for (const Band& band : bands_) {
    band.visit([&](const Box3& box) { return box.contains(p); },
               [&](const Term& term) {
                 double product = term.c;
                 for (std::size_t i = 0; i < 3; ++i) {
                   const auto a = static_cast<Eigen::Index>(i);
                   const double u = (p[a] + band.shift[a]) / band.scale[a] - term.k[i];
                   product *= function(band.factor[i]).value(u);
                 }
                 sum += product;
               });
  }
  return sum;
}

Vec3 Expansion::gradient_index(const Vec3& p) const {
  Vec3 sum = Vec3::Zero();
  for (const Band& band : bands_) {
    band.visit([&](const Box3& box) { return box.contains(p); },
               [&](const Term& term) {
                 Vec3 f, slope;
                 for (std::size_t i = 0; i < 3; ++i) {
                   const auto a = static_cast<Eigen::Index>(i);
                   const double u = (p[a] + band.shift[a]) / band.scale[a] - term.k[i];
                   f[a] = function(band.factor[i]).value(u);
                   slope[a] = function(band.factor[i]).derivative(u) / band.scale[a];
                 }
                 sum += term.c * Vec3(slope[0] * f[1] * f[2], f[0] * slope[1] * f[2], f[0] * f[1] * slope[2]);
               });
  }
  return sum;
}

}  // namespace vol::wavelet
