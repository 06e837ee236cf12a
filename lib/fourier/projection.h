#pragma once
#include <map>
#include <memory>
#include <optional>

#include "fourier/slice.h"

namespace vol::fourier {

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
  ~Projector();

  /// Seconds that project() has taken so far.
  struct Times {
    double slice = 0, inverse = 0;
  };
  [[nodiscard]] const Times& times() const { return times_; }
  /// Points at which the spectrum was resampled so far.
  [[nodiscard]] std::int64_t points() const { return points_; }

  /// \return one plane a row of `weights`, in T
  [[nodiscard]] std::vector<Buffer<T>> project(const SliceView& view, const ChannelWeights& weights);

 private:
  struct Plans;
  const SliceSource<T>& source_;
  const Filter& filter_;
  std::optional<FastSlicer> fast_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::unique_ptr<Plans>> plans_;
  Times times_;
  std::int64_t points_ = 0;

  void line(const ChannelWeights& weights, const SliceLine& line, std::complex<T>* out) const;
  std::int64_t slice_row(const SliceView& view, const ChannelWeights& weights, std::int64_t q, T* out,
                         std::int64_t columns) const;
};

/// Largest kx at which a slice is not 0 beyond doubt.
[[nodiscard]] std::int64_t used_columns(const SliceView& view);

}  // namespace vol::fourier
