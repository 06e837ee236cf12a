#include <algorithm>
#include <cmath>
#include <tuple>

#include "wavelet/line_field.h"

namespace vol::wavelet {
namespace {

std::int32_t wrapped(std::int32_t k, std::int64_t period) {
  const auto n = static_cast<std::int32_t>(period);
  return (k % n + n) % n;
}

}  // namespace

LineTerms::LineTerms(const Expansion& expansion) : expansion_(&expansion) {
  // Each function of the expansion belongs to one period at most: it is periodic on all axes that use it, or
  // on none, but where a function that was not folded is as long as the period of one of its axes.
  struct Kind {
    int function;
    bool periodic;
    bool operator==(const Kind&) const = default;
  };
  std::vector<Kind> kinds;
  const auto kind_of = [&](const Band& band, std::size_t axis) {
    const PiecewiseCubic& f = expansion.function(band.factor[axis]);
    const auto period = static_cast<double>(band.period[axis]);
    return Kind{band.factor[axis], band.period[axis] > 0 && f.upper() - f.lower == period};
  };
  for (const Band& band : expansion.bands()) {
    for (std::size_t a = 0; a < 3; ++a) {
      const Kind kind = kind_of(band, a);
      if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) kinds.push_back(kind);
    }
  }
  factors_.reserve(kinds.size());
  for (const Kind& kind : kinds) factors_.emplace_back(expansion.function(kind.function), kind.periodic);

  for (const Band& band : expansion.bands()) {
    BandTerms& own = bands_.emplace_back();
    own.band = &band;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<Eigen::Index>(i);
      const auto kind = std::find(kinds.begin(), kinds.end(), kind_of(band, i));
      Axis& axis = own.axes[i];
      axis.factor = &factors_[static_cast<std::size_t>(kind - kinds.begin())];
      const PiecewiseCubic& f = axis.factor->function();
      axis.knots = 1 / f.spacing;
      axis.per_index = axis.knots / band.scale[a];
      axis.first = (band.shift[a] / band.scale[a] - f.lower) / f.spacing;
    }
    if (!own.periodic()) continue;
    own.terms = band.terms;
    for (Term& term : own.terms) {
      for (std::size_t a = 0; a < 3; ++a) {
        if (own.axes[a].factor->periodic()) term.k[a] = wrapped(term.k[a], band.period[a]);
      }
    }
    const auto place = [](const Term& t) { return std::tie(t.k[2], t.k[1], t.k[0]); };
    std::sort(own.terms.begin(), own.terms.end(),
              [&](const Term& s, const Term& t) { return place(s) < place(t); });
    own.terms.erase(std::unique(own.terms.begin(), own.terms.end(),
                                [&](const Term& s, const Term& t) { return place(s) == place(t); }),
                    own.terms.end());
  }
}

LineTerms::Global LineTerms::global() const {
  Global sum;
  for (const BandTerms& own : bands_) {
    std::array<FactorBound, 3> whole;
    for (std::size_t i = 0; i < 3; ++i) {
      const Axis& axis = own.axes[i];
      FactorBound& f = whole[i];
      f = axis.factor->whole();
      f.slope *= axis.per_index;
      f.bend *= axis.per_index * axis.per_index;
      f.kink *= axis.per_index;
      if (own.band->period[i] == 0) f.jump = f.kink = 0;  // its ends are outside the box
      if (!axis.factor->periodic()) continue;
      // The box may be some periods long.
      const auto a = static_cast<Eigen::Index>(i);
      const Box3& box = expansion_->index_box();
      const auto pieces = static_cast<double>(axis.factor->function().pieces.size());
      const double periods = 1 + std::ceil((box.max[a] - box.min[a]) * axis.per_index / pieces);
      f.jump *= periods;
      f.kink *= periods;
    }
    const auto& [x, y, z] = whole;
    const double size = x.value * y.value * z.value;
    const double slope =
        x.slope * y.value * z.value + x.value * y.slope * z.value + x.value * y.value * z.slope;
    const double bend =
        x.bend * y.value * z.value + x.value * y.bend * z.value + x.value * y.value * z.bend +
        2 * (x.slope * y.slope * z.value + x.slope * y.value * z.slope + x.value * y.slope * z.slope);
    const double jump = x.jump * y.value * z.value + x.value * y.jump * z.value + x.value * y.value * z.jump;
    const double kink = x.kink * y.value * z.value + x.value * y.kink * z.value + x.value * y.value * z.kink;
    double c = 0;
    for (const Term& term : own.periodic() ? own.terms : own.band->terms) c += std::abs(term.c);
    sum.size += c * size;
    sum.slope += c * slope;
    sum.bend += c * bend;
    sum.jump += c * jump;
    sum.kink += c * kink;
  }
  return sum;
}

}  // namespace vol::wavelet
