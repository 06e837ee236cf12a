#include "fourier/projection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/checked.h"
#include "base/parallel.h"
#include "base/timer.h"

namespace vol::fourier {
namespace {

constexpr std::int64_t kColumns = 16;  // of the slice, transformed together
constexpr std::int64_t kRows = 8;      // of the slice or picture, a chunk for one thread

/// Whole numbers k in [from, to] for which g = origin + k step lies in the Nyquist box; empty where first >
/// last.
struct Range {
  std::int64_t first, last;
  [[nodiscard]] std::int64_t count() const { return last - first + 1; }
};
Range inside(const SliceView& view, const Vec3& origin, std::int64_t from, std::int64_t to) {
  const Vec3& step = view.per_x;
  double lo = static_cast<double>(from), hi = static_cast<double>(to);
  for (int axis = 0; axis < 3; ++axis) {
    const double most = view.nyquist[axis];
    const double reach = std::abs(step[axis]) * std::max(std::abs(lo), std::abs(hi));
    if (reach <= 1e-13 * most) continue;  // an axis seen end on, but for rounding
    const double p = (-most - origin[axis]) / step[axis], q = (most - origin[axis]) / step[axis];
    // Rounded outward by more than the quotient's error; what lies outside is taken away below.
    const double slack = 0.5;
    lo = std::max(lo, std::ceil(std::min(p, q) - slack));
    hi = std::min(hi, std::floor(std::max(p, q) + slack));
    if (!(lo <= hi)) return {0, -1};
  }
  // The ends decide in the arithmetic of those who evaluate the line, whatever its steps are: what lies
  // between two points of the box lies in it.
  Range r{static_cast<std::int64_t>(lo), static_cast<std::int64_t>(hi)};
  const auto start = [&] { return Vec3(static_cast<double>(r.first) * step + origin); };
  while (r.count() > 0 && !view.in_box(start())) ++r.first;
  while (r.count() > 0 && !view.in_box(start() + static_cast<double>(r.count() - 1) * step)) --r.last;
  return r;
}

}  // namespace

template <class T>
std::vector<std::complex<T>> centring_phases(std::int64_t count, double centre, std::int64_t n) {
  // A pixel's place from the slice's middle is i - (n - 1)/2.
  const double x = -0.5 * static_cast<double>(n - 1) - centre;
  std::vector<std::complex<T>> result(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i <= n / 2 ? i : i - n);
    const double turns = std::remainder(k * x, static_cast<double>(n)) / static_cast<double>(n);
    result[i] = std::complex<T>(std::polar(1.0, 2 * std::numbers::pi * turns));
  }
  return result;
}

namespace {

/// Rows of a power of two would put a column into one set of the cache.
std::int64_t plane_stride(std::int64_t width) {
  return (width / 2 + kColumns) / kColumns * kColumns + (width % 128 == 0 ? kColumns : 0);
}

}  // namespace

template <class T>
std::int64_t SlicePlane<T>::bytes(std::int64_t width, std::int64_t height, std::size_t channels) {
  return checked_product(
      checked_product(2 * plane_stride(width) * static_cast<std::int64_t>(sizeof(T)), height),
      static_cast<std::int64_t>(channels));
}

template <class T>
std::int64_t SlicePlane<T>::scratch_bytes(std::int64_t width, std::int64_t height) {
  return checked_product(
      std::max(ColumnTransform<T>::scratch_bytes(height, kColumns), RowTransform<T>::scratch_bytes(width)),
      thread_count());
}

template <class T>
SlicePlane<T>::SlicePlane(std::int64_t width, std::int64_t height, std::size_t channels)
    : stride_(plane_stride(width)),
      c_stride_(height),
      channels_(channels),
      along_y_(height, false, Planning::estimate),
      along_x_(width, false, Planning::estimate),
      data_(channels * static_cast<std::size_t>(2 * stride_ * height)) {}

template <class T>
std::int64_t SlicePlane<T>::columns(const SliceView& view) const {
  std::int64_t last = 0;
  for (std::int64_t ky = -(view.height / 2); ky <= view.height / 2; ++ky) {
    last = std::max(last, inside(view, static_cast<double>(ky) * view.per_y, 0, view.width / 2).last);
  }
  return std::min((last + kColumns) / kColumns * kColumns, stride_);
}

template <class T>
void SlicePlane<T>::pictures(const SliceView& view, std::int64_t columns, std::vector<Buffer<T>>& into) {
  const std::int64_t skip_x = (view.width - view.picture_width) / 2,
                     skip_y = (view.height - view.picture_height) / 2;
  into.resize(channels_);
  for (std::size_t c = 0; c < channels_; ++c) {
    parallel_for(0, columns / kColumns, 1, [&](std::int64_t begin, std::int64_t end) {
      along_y_.run(row(c, 0) + 2 * begin * kColumns, (end - begin) * kColumns, stride_);
    });
    Buffer<T>& picture = into[c];
    picture.resize(static_cast<std::size_t>(view.picture_width * view.picture_height));
    const T scale = static_cast<T>(view.scale);
    parallel_for(0, view.picture_height, kRows, [&](std::int64_t begin, std::int64_t end) {
      for (auto y = begin; y < end; ++y) {
        T* from = row(c, y + skip_y);
        std::fill(from + 2 * columns, from + std::max(2 * columns, 2 * (view.width / 2 + 1)), T{0});
        along_x_.run(from);
        T* to = picture.data() + y * view.picture_width;
        for (std::int64_t x = 0; x < view.picture_width; ++x) to[x] = from[x + skip_x] * scale;
      }
    });
  }
}

template <class T>
Projector<T>::Projector(const SliceSource<T>& source, const Filter& filter, bool plain)
    : source_(source), filter_(filter) {
  if constexpr (std::is_same_v<T, float>) {
    if (!plain) fast_.emplace(source, filter);
  }
}

template <class T>
void Projector<T>::line(const ChannelWeights& weights, const SliceLine& points, std::complex<T>* out) const {
  if constexpr (std::is_same_v<T, float>) {
    if (fast_) return fast_->line(weights, points, out);
  }
  std::vector<std::complex<double>> values(weights.size() * static_cast<std::size_t>(points.count));
  slice_line_plain(source_, filter_, weights, points, values.data());
  std::transform(values.begin(), values.end(), out, [](const auto& v) { return std::complex<T>(v); });
}

/// Row q of the Hermitian slice, in FFT order. Returns the points evaluated.
template <class T>
std::int64_t Projector<T>::slice_row(const SliceView& view, const ChannelWeights& weights,
                                     const Phases& phases, std::int64_t q, SlicePlane<T>& plane,
                                     std::int64_t columns) const {
  for (std::size_t c = 0; c < weights.size(); ++c) std::fill_n(plane.row(c, q), 2 * columns, T{0});
  thread_local std::vector<std::complex<T>> values;
  const std::int64_t half_w = view.width / 2, half_h = view.height / 2;
  const bool even_w = view.width % 2 == 0, unpaired = view.height % 2 == 0 && q == half_h;
  std::int64_t points = 0;
  const auto add = [&](std::int64_t from, std::int64_t to, std::int64_t ky, T share) {
    const Vec3 origin = static_cast<double>(ky) * view.per_y;
    const Range r = inside(view, origin, from, to);
    const std::int64_t count = r.count();
    if (count <= 0) return;
    points += count;
    values.resize(weights.size() * static_cast<std::size_t>(count));
    const SliceLine points_on{static_cast<double>(r.first) * view.per_x + origin, view.per_x, count};
    line(weights, points_on, values.data());
    // Along a line points on faces are the first ones or the last ones, or all.
    const auto shared = [&](std::int64_t i) {
      const double face = view.face_share(points_on.start + static_cast<double>(i) * points_on.step,
                                          even_w && std::abs(r.first + i) == half_w, unpaired);
      for (std::size_t c = 0; face != 1 && c < weights.size(); ++c) {
        values[c * static_cast<std::size_t>(count) + static_cast<std::size_t>(i)] *= static_cast<T>(face);
      }
      return face != 1;
    };
    std::int64_t front = 0, back = count - 1;
    while (front < count && shared(front)) ++front;
    while (back > front && shared(back)) --back;
    // exp of -k is the conjugate of that of k.
    const auto phase_y = share * (ky == -half_h && unpaired ? std::conj(phases.y[q]) : phases.y[q]);
    for (std::size_t c = 0; c < weights.size(); ++c) {
      T* row = plane.row(c, q);
      const std::complex<T>* sampled = values.data() + c * static_cast<std::size_t>(count);
      const std::complex<T>* phase_x = phases.x.data() + std::abs(r.first);
      // Below 0 lies at most one point.
      const T turn = r.first < 0 ? T(-1) : T(1);
      T* target = row + 2 * std::abs(r.first);
      for (std::int64_t i = 0; i < count; ++i) {
        const auto v = sampled[i];
        const std::complex<T> phase(phase_x[i].real(), turn * phase_x[i].imag());
        // Written out: the library's product asks each time whether it is infinite.
        const T re = phase.real() * phase_y.real() - phase.imag() * phase_y.imag();
        const T im = phase.real() * phase_y.imag() + phase.imag() * phase_y.real();
        target[2 * i] += v.real() * re - v.imag() * im;
        target[2 * i + 1] += v.real() * im + v.imag() * re;
      }
    }
  };
  // Column width/2 of an even width is the mean of -width/2 and +width/2, row height/2 likewise; where both
  // meet, of (-, -) and (+, +), which the real part pairs.
  const std::int64_t ky = q <= half_h ? q : q - view.height;
  const std::int64_t last = even_w ? half_w - 1 : half_w;
  if (unpaired) {
    add(0, last, half_h, T(0.5));
    add(0, last, -half_h, T(0.5));
    if (even_w) add(half_w, half_w, half_h, T(0.5));
    if (even_w) add(-half_w, -half_w, -half_h, T(0.5));
  } else {
    add(0, last, ky, 1);
    if (even_w) add(half_w, half_w, ky, T(0.5));
    if (even_w) add(-half_w, -half_w, ky, T(0.5));
  }
  return points;
}

template <class T>
void Projector<T>::project(const SliceView& view, const ChannelWeights& weights,
                           std::vector<Buffer<T>>& into) {
  const Timer timer;
  const std::tuple key{view.width, view.height, weights.size()};
  if (!planes_.contains(key)) {
    const std::int64_t bytes = SlicePlane<T>::bytes(view.width, view.height, weights.size());
    if (kept_ + bytes > kKeptPlanes) {
      planes_.clear();
      kept_ = 0;
    }
    planes_[key] = std::make_unique<SlicePlane<T>>(view.width, view.height, weights.size());
    kept_ += bytes;
  }
  const auto& plane = planes_[key];
  const std::int64_t columns = plane->columns(view);
  const Phases phases{centring_phases<T>(view.width / 2 + 1, view.centre_x, view.width),
                      centring_phases<T>(view.height, view.centre_y, view.height)};
  points_ += parallel_reduce<std::int64_t>(
      0, view.height, kRows,
      [&](std::int64_t begin, std::int64_t end) {
        std::int64_t points = 0;
        for (auto q = begin; q < end; ++q) points += slice_row(view, weights, phases, q, *plane, columns);
        return points;
      },
      [](std::int64_t& sum, std::int64_t part) { sum += part; });
  times_.slice += timer.seconds();
  const Timer inverse_timer;
  plane->pictures(view, columns, into);
  times_.inverse += inverse_timer.seconds();
}

template class SlicePlane<float>;
template class SlicePlane<double>;
template class Projector<float>;
template class Projector<double>;
template std::vector<std::complex<float>> centring_phases(std::int64_t, double, std::int64_t);
template std::vector<std::complex<double>> centring_phases(std::int64_t, double, std::int64_t);

}  // namespace vol::fourier
