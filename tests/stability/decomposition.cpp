#include <sstream>

#include "base/rng.h"
#include "kernels.h"
#include "truth.h"
#include "wavelet/dwt.h"
#include "wavelet/filters.h"

// Filters, and the transform there and back.
namespace vol::stability {
namespace {

using namespace vol::wavelet;

template <class T>
volume::Volume noise(const Dims& dims, double scale, double offset) {
  volume::Grid<T> grid;
  grid.geometry.dims = dims;
  grid.voxels = Buffer<T>(static_cast<std::size_t>(grid.geometry.count()));
  Rng rng(5);
  for (T& v : grid.voxels) v = static_cast<T>(offset + scale * rng.uniform(-1, 1));
  return {std::move(grid), {}};
}

template <class A>
Real norm(const A& values) {
  Real sum = 0;
  for (const auto v : values) sum += static_cast<Real>(v) * static_cast<Real>(v);
  return std::sqrt(sum);
}

template <class T>
Real norm(const Decomposition<T>& d) {
  Real sum = 0;
  for (const auto& band : d.subbands) sum += norm(band.coefficients) * norm(band.coefficients);
  return std::sqrt(sum);
}

template <class T>
const char* name_of() {
  return sizeof(T) == 4 ? "float" : "double";
}

/// |h| summed: a filtering of L taps errs by gamma_L |H| |x| component by component, and the matrix |H| of
/// both bands has no larger row or column sum, so no larger 2-norm, than this. Two more roundings for the
/// taps.
double error_of_one_filtering(const Wavelet& w, double unit) {
  double sum = 0;
  for (const double h : w.bank.h) sum += std::abs(h);
  return gamma(static_cast<double>(w.bank.taps()) + 2, unit) * sum;
}

/// What m levels of a truncated filter may miss: each is off by e = (1 + r)^3 - 1 of what it is given, and
/// passes on the next one's error, amplified by analysis and synthesis.
double truncation(const Wavelet& w, int levels) {
  const FrameBounds bounds = frame_bounds(w);
  const double amplified = std::pow(bounds.synthesis_norm, 6),
               own = std::pow(1 + bounds.round_trip_error, 3) - 1;
  double error = 0;
  for (int m = 0; m < levels; ++m) error = own + amplified * error;
  return error;
}

struct Case {
  Dims dims;
  int levels;
  double scale = 1, offset = 0;
};

/// Largest error of the way there and back, and of the energy, over all wavelets that are meant.
template <class T>
void round_trips(Table& table, const std::string& what, const std::vector<Case>& cases, Boundary boundary,
                 bool truncated) {
  Worst there_and_back, energy;
  for (const std::string& name : wavelet_names()) {
    const Wavelet w = make_wavelet(name);
    if (w.orthonormal == truncated) continue;
    if (boundary == Boundary::symmetric && !w.compact) continue;  // keeps 100 coefficients beyond each end
    for (const Case& c : cases) {
      const auto f = noise<T>(c.dims, c.scale, c.offset);
      const auto& voxels = std::get<volume::Grid<T>>(f.grid).voxels;
      const auto d =
          analyze<T>(f, {.wavelet = name, .levels = c.levels, .boundary = boundary}, volume::value_range(f));
      const auto back = synthesize(d);
      Real error = 0;
      for (std::size_t n = 0; n < voxels.size(); ++n) {
        const Real e = static_cast<Real>(back.voxels[n]) - static_cast<Real>(voxels[n]);
        error += e * e;
      }
      // The box may have been extended, and expansive coefficients be more than it: what is filtered is no
      // larger than the coefficients (periodic: as large, but for rounding).
      const Real size = std::max(norm(d), norm(voxels));
      const double filterings = 6.0 * c.levels * error_of_one_filtering(w, kUnit<T>);
      there_and_back.add(static_cast<double>(std::sqrt(error) / size), filterings + truncation(w, c.levels));
      if (boundary == Boundary::periodic && !truncated && c.dims == d.extended_dims) {
        energy.add(static_cast<double>(std::abs(norm(d) / norm(voxels) - 1)), filterings / 2);
      }
    }
  }
  const char* orthonormal = "6 m gamma_(L+2) sum|h|, of L taps and m levels";
  table.row(what, truncated ? "there and back, truncated filters" : "there and back, all filters",
            name_of<T>(), there_and_back,
            truncated ? "frame_bounds(): ((1+r)^3 - 1) a level, amplified" : orthonormal);
  if (energy.count() > 0)
    table.row(what, "energy, all filters", name_of<T>(), energy, "3 m gamma_(L+2) sum|h|");
}

template <class T>
void in_precision(Table& table) {
  const std::vector<Case> small{{{1, 1, 1}, 1}, {{2, 2, 2}, 1}, {{3, 3, 3}, 1},
                                {{2, 3, 1}, 2}, {{5, 1, 7}, 2}, {{13, 17, 11}, 3}};
  const std::vector<Case> deep{{{1, 1, 4096}, 12}, {{32, 32, 32}, 5}, {{64, 4, 16}, 2}};
  for (const bool truncated : {false, true}) {
    round_trips<T>(table, "sizes 1, 2, 3 and primes", small, Boundary::periodic, truncated);
    round_trips<T>(table, "1 x 1 x 4096 and 32^3 to the last level", deep, Boundary::periodic, truncated);
  }
  round_trips<T>(table, "symmetric boundary: sizes 1, 2, 3 and primes", small, Boundary::symmetric, false);
  round_trips<T>(table, "values 1e30", {{{16, 8, 32}, 3, 1e30}}, Boundary::periodic, false);
  round_trips<T>(table, "values 1e-30", {{{16, 8, 32}, 3, 1e-30}}, Boundary::periodic, false);
  round_trips<T>(table, "signal 1 on 1e8", {{{16, 8, 32}, 3, 1, 1e8}}, Boundary::periodic, false);
  table.refusal("values whose coefficients overflow", "analyze", name_of<T>(), [] {
    const auto f = noise<T>({8, 8, 8}, static_cast<double>(std::numeric_limits<T>::max()) / 4, 0);
    (void)analyze<T>(f, {.wavelet = "haar", .levels = 3}, volume::value_range(f));
  });
}

/// sum h[n] h[n + 2k] = (k = 0), sum h[n] g[n + 2k] = 0, sum h = sqrt 2.
void filters(Table& table) {
  Worst worst;
  for (const std::string& name : wavelet_names()) {
    const Wavelet w = make_wavelet(name);
    if (!w.orthonormal) continue;
    const auto& h = w.bank.h;
    const auto& g = w.bank.g;
    const auto taps = static_cast<std::int64_t>(h.size());
    Real total = 0;
    for (const double x : h) total += static_cast<Real>(x);
    double sum = 0;
    for (const double x : h) sum += std::abs(x);
    // Every tap is rounded once; an infinite filter lacks a tail of 1e-16 at each end.
    const double bound = 2 * kDouble * std::max(1.0, sum) + (w.compact ? 0 : 4e-16);
    worst.add(static_cast<double>(std::abs(total - std::sqrt(static_cast<Real>(2)))), bound);
    for (std::int64_t k = 0; 2 * k < taps; ++k) {
      Real hh = k == 0 ? -1 : 0, hg = 0, gh = 0;
      for (std::int64_t n = 0; n + 2 * k < taps; ++n) {
        hh += static_cast<Real>(h[n]) * static_cast<Real>(h[n + 2 * k]);
        hg += static_cast<Real>(h[n]) * static_cast<Real>(g[n + 2 * k]);
        gh += static_cast<Real>(g[n]) * static_cast<Real>(h[n + 2 * k]);
      }
      for (const Real e : {hh, hg, gh}) worst.add(static_cast<double>(std::abs(e)), bound);
    }
  }
  table.row("all filters orthonormal", "make_wavelet", "double", worst,
            "taps rounded once: 2 u sum|h|; infinite ones less a tail of 1e-16");
}

}  // namespace

void decomposition(Table& table) {
  filters(table);
  in_precision<float>(table);
  in_precision<double>(table);
  table.refusal("more levels than a small volume bears", "analyze", "double", [] {
    const auto f = noise<double>({3, 3, 3}, 1, 0);
    (void)analyze<double>(f, {.wavelet = "haar", .levels = 12}, volume::value_range(f));
  });
  table.refusal("infinity in the volume", "value_range", "double", [] {
    auto f = noise<double>({3, 3, 3}, 1, 0);
    std::get<volume::Grid<double>>(f.grid).voxels[7] = HUGE_VAL;
    (void)volume::value_range(f);
  });
}

}  // namespace vol::stability
