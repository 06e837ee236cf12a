#include "wavelet/expansion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "base/error.h"
#include "volume/grid_sampler.h"
#include "wavelet/initialisation.h"
#include "wavelet/layout.h"
#include "wavelet/spline_basis.h"

namespace vol::wavelet {
namespace {

/// Puts the terms in Morton order, in place, and builds the boxes over them.
void sort_and_build(Band& band) {
  std::array<std::int32_t, 3> least;
  least.fill(std::numeric_limits<std::int32_t>::max());
  for (const Term& t : band.terms) {
    for (std::size_t a = 0; a < 3; ++a) least[a] = std::min(least[a], t.k[a]);
  }
  // Without interleaving bits, and so of any length: the axis decides on which the highest bit differs.
  const auto before = [&least](const Term& s, const Term& t) {
    std::size_t decides = 2;
    std::uint32_t highest = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const auto from = static_cast<std::uint32_t>(least[a]);
      const std::uint32_t differs =
          (static_cast<std::uint32_t>(s.k[a]) - from) ^ (static_cast<std::uint32_t>(t.k[a]) - from);
      if (highest >= differs || highest >= (highest ^ differs)) continue;  // its highest bit is not above
      highest = differs;
      decides = a;
    }
    return s.k[decides] < t.k[decides];
  };
  std::sort(band.terms.begin(), band.terms.end(), before);

  const auto parents = [](std::size_t count, const auto& child) {
    std::vector<Band::Node> nodes;
    nodes.reserve((count + Band::kFanout - 1) / Band::kFanout);
    for (std::size_t begin = 0; begin < count; begin += Band::kFanout) {
      Band::Node& node = nodes.emplace_back(child(begin));
      for (std::size_t i = begin + 1; i < std::min(count, begin + Band::kFanout); ++i) {
        const Band::Node other = child(i);
        for (std::size_t a = 0; a < 3; ++a) {
          node.lower[a] = std::min(node.lower[a], other.lower[a]);
          node.upper[a] = std::max(node.upper[a], other.upper[a]);
        }
      }
    }
    return nodes;
  };
  band.nodes.push_back(parents(band.terms.size(), [&band](std::size_t i) {
    return Band::Node{band.terms[i].k, band.terms[i].k};
  }));
  while (band.nodes.back().size() > 1) {
    const auto& below = band.nodes.back();
    auto above = parents(below.size(), [&below](std::size_t i) { return below[i]; });
    band.nodes.push_back(std::move(above));
  }
}

/// Of a band of these many terms, and their tree.
std::int64_t band_bytes(std::int64_t terms) {
  constexpr auto kFanout = static_cast<std::int64_t>(Band::kFanout);
  std::int64_t bytes = terms * static_cast<std::int64_t>(sizeof(Term)), nodes = terms;
  do {
    nodes = (nodes + kFanout - 1) / kFanout;
    bytes += nodes * static_cast<std::int64_t>(sizeof(Band::Node));
  } while (nodes > 1);
  return bytes;
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

std::int64_t number_of_coefficients(const Band& band, std::size_t axis) {
  return std::max<std::int64_t>(1, band.period[axis]);
}

Images axis_images(const Band& band, std::size_t axis, std::int64_t k, const Box3& box) {
  if (band.period[axis] == 0) return {0, 0};
  const auto a = static_cast<int>(axis);
  return images(band, a, k, band.period[axis], box.max[a]);
}

/// Calls f(c, k) for every place k where the function of a coefficient c other than 0 meets the box. The
/// coefficients are as many as the band's period, x fastest.
template <class Coefficients, class F>
void for_each_term(const Coefficients& coefficients, const Box3& box, const Band& band, const F& f) {
  const auto& period = band.period;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < number_of_coefficients(band, 2); ++k) {
    const Images z = axis_images(band, 2, k, box);
    for (std::int64_t j = 0; j < number_of_coefficients(band, 1); ++j) {
      const Images y = axis_images(band, 1, j, box);
      for (std::int64_t i = 0; i < number_of_coefficients(band, 0); ++i, ++at) {
        const auto c = static_cast<double>(coefficients[at]);
        if (c == 0) continue;
        const Images x = axis_images(band, 0, i, box);
        for (std::int64_t w = z.first; w <= z.last; ++w) {
          for (std::int64_t v = y.first; v <= y.last; ++v) {
            for (std::int64_t u = x.first; u <= x.last; ++u) {
              f(c, std::array{static_cast<std::int32_t>(i + u * period[0]),
                              static_cast<std::int32_t>(j + v * period[1]),
                              static_cast<std::int32_t>(k + w * period[2])});
            }
          }
        }
      }
    }
  }
}

/// Places of a band none of whose coefficients is 0.
std::int64_t all_places(const Band& band, const Box3& box) {
  std::int64_t places = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    std::int64_t along = 0;
    for (std::int64_t k = 0; k < number_of_coefficients(band, a); ++k) {
      const Images found = axis_images(band, a, k, box);
      along += std::max<std::int64_t>(0, found.last - found.first + 1);
    }
    places *= along;
  }
  return places;
}

/// Terms of a band that a point of the box meets, on average.
double terms_at_a_point(const Band& band, std::int64_t terms, const Box3& box) {
  double share = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const double width = band.scale[a] * (band.upper[a] - band.lower[a]);
    share *= std::min(1.0, width / (width + box.max[a] - box.min[a]));
  }
  return share * static_cast<double>(terms);
}

std::array<SplineAxis, 3> spline_axes(const Band& band) {
  std::array<SplineAxis, 3> axes;
  for (std::size_t a = 0; a < 3; ++a) {
    const bool detail = (band.orientation >> a & 1) != 0;
    axes[a] = band.period[a] == 0 ? SplineAxis::none : detail ? SplineAxis::psi : SplineAxis::phi;
  }
  return axes;
}

/// The B-splines of a band take as much memory as the volume at its level, whatever the number of its terms:
/// not more than this, 96 MiB of terms.
constexpr std::int64_t kMostBSplines = std::int64_t{1} << 22;

template <class T>
std::int64_t bytes_of(const Subband<T>& subband) {
  return static_cast<std::int64_t>(subband.coefficients.size() * sizeof(T));
}

}  // namespace

Box3 Band::box(const Node& node) const {
  Box3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    const double low = scale[a] * (node.lower[i] + lower[a]), high = scale[a] * (node.upper[i] + upper[a]);
    // Whoever adds the shift to a place of the function finds it within low and high: no rounding of the
    // difference may keep that place out of the box.
    const double rounding = 4 * std::numeric_limits<double>::epsilon();
    result.min[a] = low - shift[a] - rounding * (std::abs(low) + std::abs(shift[a]));
    result.max[a] = high - shift[a] + rounding * (std::abs(high) + std::abs(shift[a]));
  }
  return result;
}

template <class T>
Expansion::Expansion(Decomposition<T> decomposition, const ExpansionOptions& options)
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
  if (decomposition.initialisation == Initialisation::interpolate) {
    require_interpolation(wavelet, decomposition.boundary);
  }
  const double shift = expansion_shift(wavelet, decomposition.initialisation);
  const Prototypes prototypes = make_prototypes(wavelet, options.depth);
  phi_deviation_ = prototypes.phi_deviation;
  psi_deviation_ = prototypes.psi_deviation;
  functions_.push_back({-1, 2, {{1, 0, 0, 0}}});  // along an axis of one sample
  std::vector<Band> bands;                        // empty, one for each subband
  for (const auto& subband : decomposition.subbands) {
    Band& band = bands.emplace_back();
    band.level = subband.level;
    band.orientation = subband.orientation;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      if (extended[i] > 1) {
        const bool detail = (subband.orientation >> i & 1) != 0;
        band.period[i] = extended[i] >> subband.level;
        band.factor[i] = number_of(periodised(detail ? prototypes.psi : prototypes.phi, band.period[i]));
        band.scale[a] = std::ldexp(1.0, subband.level);
        band.shift[a] = shift;
        band.weight /= std::sqrt(band.scale[a]);
      }
      band.lower[a] = function(band.factor[i]).lower;
      band.upper[a] = function(band.factor[i]).upper();
    }
  }
  std::optional<SplineBasis> basis;
  if (options.b_splines && wavelet.family == Family::battle_lemarie)
    basis = battle_lemarie_basis(wavelet.degree);
  const std::vector<std::int64_t> terms =
      count_terms(decomposition, basis ? &*basis : nullptr, bands, options.memory_limit);
  for (std::size_t b = 0; b < bands.size(); ++b) {
    Band& band = bands[b];
    const auto add = [&band](double c, const std::array<std::int32_t, 3>& k) {
      band.terms.push_back({c * band.weight, k});
    };
    auto& coefficients = decomposition.subbands[b].coefficients;
    if (band.b_splines) {
      std::vector<double> own(coefficients.begin(), coefficients.end());
      coefficients = {};
      Dims dims = decomposition.subbands[b].dims;
      const std::vector<double> splines = to_b_splines(*basis, std::move(own), dims, spline_axes(band));
      std::int64_t count = 0;
      for_each_term(splines, box_, band, [&](double, const auto&) { ++count; });
      band.terms.reserve(static_cast<std::size_t>(count));
      for_each_term(splines, box_, band, add);
    } else {
      band.terms.reserve(static_cast<std::size_t>(terms[b]));
      for_each_term(coefficients, box_, band, add);
      coefficients = {};
    }
    if (band.terms.empty()) continue;
    sort_and_build(band);
    bands_.push_back(std::move(band));
  }
}

int Expansion::number_of(const PiecewiseCubic& f) {
  const auto same = std::find_if(functions_.begin(), functions_.end(), [&](const auto& g) {
    return g.lower == f.lower && g.spacing == f.spacing && g.pieces == f.pieces;
  });
  const auto number = static_cast<int>(same - functions_.begin());
  if (same == functions_.end()) functions_.push_back(f);
  return number;
}

template <class T>
std::vector<std::int64_t> Expansion::count_terms(const Decomposition<T>& decomposition,
                                                 const SplineBasis* basis, std::vector<Band>& bands,
                                                 std::int64_t limit) {
  std::vector<std::int64_t> terms;
  std::int64_t all = 0, bytes = 0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const auto& subband = decomposition.subbands[b];
    Band& band = bands[b];
    terms.push_back(0);
    for_each_term(subband.coefficients, box_, band, [&](double, const auto&) { ++terms.back(); });
    if (basis != nullptr) {
      Band splines = band;
      splines.b_splines = true;
      const auto axes = spline_axes(band);
      for (std::size_t i = 0; i < 3; ++i) {
        const auto a = static_cast<Eigen::Index>(i);
        if (axes[i] == SplineAxis::none) continue;
        splines.period[i] = spline_length(axes[i], band.period[i]);
        splines.scale[a] = axes[i] == SplineAxis::psi ? band.scale[a] / 2 : band.scale[a];
        const PiecewiseCubic f = periodised(basis->beta, splines.period[i]);
        splines.lower[a] = f.lower;
        splines.upper[a] = f.upper();
      }
      const std::int64_t places = all_places(splines, box_);
      if (terms.back() > 0 && places <= kMostBSplines &&
          terms_at_a_point(band, terms.back(), box_) > terms_at_a_point(splines, places, box_)) {
        for (std::size_t i = 0; i < 3; ++i) {
          if (axes[i] != SplineAxis::none)
            splines.factor[i] = number_of(periodised(basis->beta, splines.period[i]));
        }
        band = std::move(splines);
        terms.back() = places;
      }
    }
    all += terms.back();
    bytes += bytes_of(subband);
    coefficients_ += std::count_if(subband.coefficients.begin(), subband.coefficients.end(),
                                   [](T c) { return c != T{0}; });
  }
  planned_bytes_ = bytes;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const Band& band = bands[b];
    if (band.b_splines) {
      // As doubles, of the axis before and behind it.
      const std::int64_t doubles = 2 * number_of_coefficients(band, 0) * number_of_coefficients(band, 1) *
                                   number_of_coefficients(band, 2) *
                                   static_cast<std::int64_t>(sizeof(double));
      planned_bytes_ = std::max(planned_bytes_, bytes + doubles + band_bytes(terms[b]));
    }
    if (terms[b] > 0) bytes += band_bytes(terms[b]);
    planned_bytes_ = std::max(planned_bytes_, bytes);
    bytes -= bytes_of(decomposition.subbands[b]);
  }
  if (planned_bytes_ > limit) {
    throw Error(std::to_string(coefficients_) + " coefficients that are not zero, at " + std::to_string(all) +
                " places, would take " + std::to_string(planned_bytes_ >> 20) + " MiB, of " +
                std::to_string(limit >> 20) + " MiB of memory; keep fewer of them");
  }
  return terms;
}

template Expansion::Expansion(Decomposition<float>, const ExpansionOptions&);
template Expansion::Expansion(Decomposition<double>, const ExpansionOptions&);

std::int64_t Expansion::bytes_from(int finest) const {
  std::int64_t bytes = 0;
  for (const Band& band : bands_) {
    if (band.level >= finest) bytes += band_bytes(static_cast<std::int64_t>(band.terms.size()));
  }
  return bytes;
}

Expansion Expansion::from_level(int finest, std::int64_t memory_limit) const {
  const std::int64_t own = bytes_from(finest), whole = bytes_from(std::numeric_limits<int>::min());
  if (own > memory_limit - whole) {
    throw Error("a copy of the coefficients from level " + std::to_string(finest) + " on would take " +
                std::to_string(own >> 20) + " MiB beside the whole's " + std::to_string(whole >> 20) +
                ", of " + std::to_string(memory_limit >> 20) +
                " MiB of memory; keep fewer of them, or draw no coarse pictures first");
  }
  Expansion result;
  result.geometry_ = geometry_;
  result.bounds_ = bounds_;
  result.box_ = box_;
  result.world_to_index_ = world_to_index_;
  result.functions_ = functions_;
  for (const Band& band : bands_) {
    if (band.level >= finest) result.bands_.push_back(band);
  }
  result.coefficients_ = coefficients_;
  result.planned_bytes_ = planned_bytes_;
  result.phi_deviation_ = phi_deviation_;
  result.psi_deviation_ = psi_deviation_;
  return result;
}

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
                   product *=
                       function(band.factor[i]).value((p[a] + band.shift[a]) / band.scale[a], term.k[i]);
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
                   const double v = (p[a] + band.shift[a]) / band.scale[a];
                   f[a] = function(band.factor[i]).value(v, term.k[i]);
                   slope[a] = function(band.factor[i]).derivative(v, term.k[i]) / band.scale[a];
                 }
                 sum += term.c * Vec3(slope[0] * f[1] * f[2], f[0] * slope[1] * f[2], f[0] * f[1] * slope[2]);
               });
  }
  return sum;
}

}  // namespace vol::wavelet
