#include "wavelet/spline_basis.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace vol::wavelet {
namespace {

/// taps[m], m counted from `first`, summed up to one period of n.
std::vector<double> folded(const std::vector<double>& taps, std::int64_t first, std::int64_t n) {
  std::vector<double> result(static_cast<std::size_t>(n), 0.0);
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const std::int64_t m = first + static_cast<std::int64_t>(i);
    result[static_cast<std::size_t>((m % n + n) % n)] += taps[i];
  }
  return result;
}

/// One line: d[j] = sum_k c[k] taps[j - stride k], periodic.
class LineFilter {
 public:
  LineFilter(const std::vector<double>& taps, std::int64_t first, std::int64_t stride, std::int64_t length)
      : stride_(stride), length_(length) {
    const auto count = static_cast<std::int64_t>(taps.size());
    if (count >= length) {
      taps_ = folded(taps, first, length);
      first_ = 0;
    } else {
      taps_ = taps;
      first_ = (first % length + length) % length;
    }
  }

  void run(const double* c, std::int64_t n, std::vector<double>& d) const {
    std::fill(d.begin(), d.end(), 0.0);
    for (std::int64_t k = 0; k < n; ++k) {
      if (c[k] == 0) continue;
      auto at = static_cast<std::size_t>((first_ + stride_ * k) % length_);
      std::size_t tap = 0;
      while (tap < taps_.size()) {
        const std::size_t run = std::min(taps_.size() - tap, static_cast<std::size_t>(length_) - at);
        for (std::size_t i = 0; i < run; ++i) d[at + i] += c[k] * taps_[tap + i];
        tap += run;
        at = 0;
      }
    }
  }

 private:
  std::int64_t stride_, length_, first_;
  std::vector<double> taps_;
};

}  // namespace

std::vector<double> to_b_splines(const SplineBasis& basis, std::vector<double> coefficients, Dims& dims,
                                 const std::array<SplineAxis, 3>& axes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axes[axis] == SplineAxis::none) continue;
    const bool psi = axes[axis] == SplineAxis::psi;
    const std::int64_t n = dims[axis], length = spline_length(axes[axis], n);
    const LineFilter filter =
        psi ? LineFilter(basis.b, basis.first_b, 2, length) : LineFilter(basis.a, basis.first_a, 1, length);
    std::int64_t inner = 1, outer = 1;  // lines lie `inner` apart
    for (std::size_t b = 0; b < 3; ++b) (b < axis ? inner : outer) *= b == axis ? 1 : dims[b];
    std::vector<double> result(static_cast<std::size_t>(inner * outer * length));
    parallel_for(0, inner * outer, 256, [&](std::int64_t begin, std::int64_t end) {
      std::vector<double> from(static_cast<std::size_t>(n)), to(static_cast<std::size_t>(length));
      for (std::int64_t line = begin; line < end; ++line) {
        const std::int64_t i = line % inner, o = line / inner;
        for (std::int64_t k = 0; k < n; ++k) {
          from[static_cast<std::size_t>(k)] = coefficients[static_cast<std::size_t>((o * n + k) * inner + i)];
        }
        filter.run(from.data(), n, to);
        for (std::int64_t j = 0; j < length; ++j) {
          result[static_cast<std::size_t>((o * length + j) * inner + i)] = to[static_cast<std::size_t>(j)];
        }
      }
    });
    coefficients = std::move(result);
    dims[axis] = length;
  }
  double largest = 0;
  for (const double c : coefficients) largest = std::max(largest, std::abs(c));
  for (double& c : coefficients) {
    if (std::abs(c) < 1e-17 * largest) c = 0;
  }
  return coefficients;
}

}  // namespace vol::wavelet
