#include <algorithm>
#include <cmath>
#include <limits>

#include "wavelet/expansion.h"

namespace vol::wavelet {
namespace {

/// One factor along the line: at t it is read at q0 + t dq, counted in knot distances from its first knot.
struct Track {
  const PiecewiseCubic* f = nullptr;
  double q0 = 0, dq = 0;
  double next = 0;  ///< t of the next knot
  double knot = 0;  ///< its number
  double step = 0;  ///< +-1

  [[nodiscard]] double crossing(double number) const {
    return dq == 0 ? std::numeric_limits<double>::infinity() : (number - q0) / dq;
  }
};

/// The factor about the middle of a piece: coefficients of s, t = middle + length s, |s| <= 1/2.
std::array<double, 4> about(const Track& track, double middle, double length) {
  const double q = track.q0 + track.dq * middle;
  const auto last = static_cast<double>(track.f->pieces.size() - 1);
  const double i = std::clamp(std::floor(q), 0.0, last);  // at the ends rounding may lead outside
  const double v = q - i;
  const double h = track.dq * length;
  const auto& a = track.f->pieces[static_cast<std::size_t>(i)];
  return {a[0] + v * (a[1] + v * (a[2] + v * a[3])), h * (a[1] + v * (2 * a[2] + v * 3 * a[3])),
          h * h * (a[2] + v * 3 * a[3]), h * h * h * a[3]};
}

/// Integral of x y z over |s| <= 1/2: only even powers count, s^2n gives 4^-n / (2n + 1).
double integral_of_product(const std::array<double, 4>& x, const std::array<double, 4>& y,
                           const std::array<double, 4>& z) {
  std::array<double, 7> xy{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) xy[i + j] += x[i] * y[j];
  }
  const double p0 = xy[0] * z[0];
  const double p2 = xy[0] * z[2] + xy[1] * z[1] + xy[2] * z[0];
  const double p4 = xy[1] * z[3] + xy[2] * z[2] + xy[3] * z[1] + xy[4] * z[0];
  const double p6 = xy[3] * z[3] + xy[4] * z[2] + xy[5] * z[1] + xy[6] * z[0];
  const double p8 = xy[5] * z[3] + xy[6] * z[2];
  return p0 + p2 / 12 + p4 / 80 + p6 / 448 + p8 / 2304;
}

/// Calls f(to, integral) for each of the function's polynomial pieces on the line, in the order of t; without
/// the coefficient.
template <class F>
void for_each_piece(const Expansion& expansion, const Band& band, const Term& term, const Vec3& origin,
                    const Vec3& direction, double begin, double end, const F& f) {
  // t counts from the middle of what is asked for: far from the ray's origin no digits are lost.
  std::array<Track, 3> tracks;
  const double from = 0.5 * (begin + end);
  double a = begin - from, b = end - from;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    Track& track = tracks[i];
    track.f = &expansion.function(band.factor[i]);
    const double per_index = 1 / (band.scale[axis] * track.f->spacing);
    const double x = origin[axis] + from * direction[axis];
    const double v = (x + band.shift[axis]) / band.scale[axis];
    track.q0 = (v - term.k[i] - track.f->lower) / track.f->spacing;
    track.dq = direction[axis] * per_index;
    const auto n = static_cast<double>(track.f->pieces.size());
    const double first = track.crossing(0), last = track.crossing(n);
    if (track.dq == 0) {
      if (!track.f->covers(v, term.k[i])) return;
    } else {
      a = std::max(a, std::min(first, last));
      b = std::min(b, std::max(first, last));
    }
  }
  if (!(a < b)) return;
  for (Track& track : tracks) {
    track.step = track.dq < 0 ? -1 : 1;
    const double q = track.q0 + track.dq * a;
    track.knot = track.dq < 0 ? std::ceil(q) - 1 : std::floor(q) + 1;
    track.next = track.crossing(track.knot);
  }
  while (a < b) {
    const double to = std::min({b, tracks[0].next, tracks[1].next, tracks[2].next});
    if (to > a) {
      const double middle = 0.5 * (a + to), length = to - a;
      f(from + to,
        length * integral_of_product(about(tracks[0], middle, length), about(tracks[1], middle, length),
                                     about(tracks[2], middle, length)));
      a = to;
    }
    for (Track& track : tracks) {
      if (track.next <= a) {
        track.knot += track.step;
        track.next = track.crossing(track.knot);
      }
    }
  }
}

}  // namespace

double line_integral(const Expansion& expansion, const Band& band, const Term& term, const Vec3& origin,
                     const Vec3& direction, double begin, double end, std::int64_t* pieces) {
  double sum = 0;
  for_each_piece(expansion, band, term, origin, direction, begin, end, [&](double, double integral) {
    sum += integral;
    if (pieces != nullptr) ++*pieces;
  });
  return term.c * sum;
}

void line_intervals(const Expansion& expansion, const Band& band, const Term& term, const Vec3& origin,
                    const Vec3& direction, double begin, double end, std::vector<LineInterval>& intervals) {
  intervals.clear();
  for_each_piece(expansion, band, term, origin, direction, begin, end, [&](double to, double integral) {
    intervals.push_back({to, term.c * integral});
  });
}

}  // namespace vol::wavelet
