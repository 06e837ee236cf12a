#pragma once
#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "fourier/slice.h"

namespace vol::fourier {

/// The half of a picture's transform that a slice fills, and the way from there to the picture.
template <class T>
class SlicePlane {
 public:
  SlicePlane(std::int64_t width, std::int64_t height, std::size_t channels);

  /// Row q of channel c, in FFT order; kx = 0 .. floor(width/2), interleaved complex.
  [[nodiscard]] T* row(std::size_t c, std::int64_t q) {
    return data_.data() + 2 * stride_ * (c_stride_ * static_cast<std::int64_t>(c) + q);
  }
  [[nodiscard]] std::int64_t stride() const { return stride_; }  ///< complex numbers
  /// Bytes that a plane of this size takes.
  [[nodiscard]] static std::int64_t bytes(std::int64_t width, std::int64_t height, std::size_t channels);
  /// Bytes that pictures() takes besides, on all threads together.
  [[nodiscard]] static std::int64_t scratch_bytes(std::int64_t width, std::int64_t height);
  /// Columns from which on all is 0, rounded up to what is transformed together.
  [[nodiscard]] std::int64_t columns(const SliceView& view) const;
  /// Inverse transforms of the first `columns` columns and of the picture's rows; overwrites the plane.
  void pictures(const SliceView& view, std::int64_t columns, std::vector<Buffer<T>>& into);

 private:
  std::int64_t stride_, c_stride_;
  std::size_t channels_;
  ColumnTransform<T> along_y_;
  RowTransform<T> along_x_;
  Buffer<T> data_;
};

/// Planes of several sizes are kept from picture to picture up to these many bytes together, or one larger
/// one.
inline constexpr std::int64_t kKeptPlanes = std::int64_t{64} << 20;

/// Pictures of one spectrum by the projection-slice theorem: slice, inverse transform, scale. A pixel is the
/// sum over samples times world length: the real part of
///
///     scale sum over kx, ky of F(kx per_x + ky per_y) exp(2 pi i (kx (x - centre_x) / width + ky (y -
///     centre_y) / height))
///
/// for kx = -floor(width/2) .. and ky likewise, x and y in pixels from the picture's middle. Of an even size
/// the unpaired line thereby counts as the mean of both Nyquist lines. Plans and buffers are kept from
/// picture to picture.
template <class T>
class Projector {
 public:
  /// Both must live longer. `plain`: slice_line_plain even where T is float.
  Projector(const SliceSource<T>& source, const Filter& filter, bool plain = false);

  /// Seconds that project() has taken so far.
  struct Times {
    double slice = 0, inverse = 0;
  };
  [[nodiscard]] const Times& times() const { return times_; }
  /// Points at which the spectrum was resampled so far.
  [[nodiscard]] std::int64_t points() const { return points_; }

  /// One plane a row of `weights`, in T; what memory `into` has already is used again.
  void project(const SliceView& view, const ChannelWeights& weights, std::vector<Buffer<T>>& into);
  [[nodiscard]] std::vector<Buffer<T>> project(const SliceView& view, const ChannelWeights& weights) {
    std::vector<Buffer<T>> pictures;
    project(view, weights, pictures);
    return pictures;
  }

 private:
  const SliceSource<T>& source_;
  const Filter& filter_;
  std::optional<FastSlicer> fast_;
  std::map<std::tuple<std::int64_t, std::int64_t, std::size_t>, std::unique_ptr<SlicePlane<T>>> planes_;
  std::int64_t kept_ = 0;  // bytes of planes_
  Times times_;
  std::int64_t points_ = 0;

  void line(const ChannelWeights& weights, const SliceLine& line, std::complex<T>* out) const;
  /// Phases that bring the volume's centre to its pixel, for kx = 0 .. floor(width/2) and ky = 0 .. height -
  /// 1 in FFT order.
  struct Phases {
    std::vector<std::complex<T>> x, y;
  };
  std::int64_t slice_row(const SliceView& view, const ChannelWeights& weights, const Phases& phases,
                         std::int64_t q, SlicePlane<T>& plane, std::int64_t columns) const;
};

/// What brings the volume's centre, `centre` pixels from the middle of n, to its pixel: exp(-2 pi i k ((n -
/// 1)/2 + centre)/n) for the first `count` frequencies k in FFT order.
template <class T>
[[nodiscard]] std::vector<std::complex<T>> centring_phases(std::int64_t count, double centre, std::int64_t n);

}  // namespace vol::fourier
