#pragma once
#include <array>
#include <complex>
#include <vector>

#include "camera/camera.h"
#include "fourier/slice_source.h"

namespace vol::fourier {

/// An orthographic view in the spectrum's terms. Slice frequency (kx, ky), both centred, stands for kx/(width
/// pitch) cycles per world length to the right in the picture and ky/(height pitch) down; it lies at g = kx
/// per_x + ky per_y grid steps of the spectrum from its centre.
struct SliceView {
  Vec3 per_x = Vec3::Zero(), per_y = Vec3::Zero();
  Vec3 nyquist = Vec3::Zero();         ///< M/2: beyond it the slice is 0, on it half
  std::int64_t width = 0, height = 0;  ///< of the slice: as the picture's, or larger by an even number
  std::int64_t picture_width = 0, picture_height = 0;
  double centre_x = 0,
         centre_y = 0;  ///< pixels from the slice's middle, right and down, to the volume's centre
  double pitch = 1;     ///< world length of a pixel
  double scale = 1;     ///< pixel = scale times the unnormalised inverse transform

  /// g is rounded: this share of M/2 above or below counts as on the face. Rounding is below 1e-15 of M/2 a
  /// term.
  static constexpr double kRounding = 1e-10;
  /// |g_a| <= M_a/2 on every axis; false for NaN.
  [[nodiscard]] bool in_box(const Vec3& g) const;
  /// 1/2 for every axis with |g_a| = M_a/2, as both ends of the spectrum's period stand for one frequency;
  /// else 1. `unpaired_x`, `unpaired_y`: g is on the picture's own unpaired line, kx = +-width/2 or ky =
  /// +-height/2. Where that whole line lies in the face, the mean of both lines that the picture takes is
  /// the face's share already.
  [[nodiscard]] double face_share(const Vec3& g, bool unpaired_x, bool unpaired_y) const;
};

/// \param wrap  take the slice at the picture's own frequencies: what lies outside the picture then wraps
/// around into
///              it. Otherwise the slice is as wide as picture and volume need together, and cut.
/// \throws vol::Error for a perspective view, or one in which a pixel is so small that the slice passes 32768
[[nodiscard]] SliceView slice_view(const SpectrumInfo& info, const camera::Camera& camera, int width,
                                   int height, bool wrap);

/// Points of a slice along a line: g = start + i step, i = 0 .. count - 1.
struct SliceLine {
  Vec3 start, step;
  std::int64_t count;
};

/// What the channels of a picture are made of: channels[c][f] times spectrum f.
using ChannelWeights = std::vector<std::vector<double>>;

/// The resampled spectrum along a line, evaluated as it is written in filter.h, in double: the oracle of the
/// fast one, and what double spectra are drawn with. `out`: channel by channel, `count` numbers each.
template <class T>
void slice_line_plain(const SliceSource<T>& source, const Filter& filter, const ChannelWeights& weights,
                      const SliceLine& line, std::complex<double>* out);

/// The same in float, by SIMD, with the filter's weights as polynomials. Every instruction set gives the same
/// bits.
class FastSlicer {
 public:
  FastSlicer(const SliceSource<float>& source, const Filter& filter);
  void line(const ChannelWeights& weights, const SliceLine& line, std::complex<float>* out) const;

 private:
  const SliceSource<float>& source_;
  int taps_, degree_;
  Buffer<float> single_, pairs_;  // coefficients, rows of 16 taps; the second with every tap twice
};

}  // namespace vol::fourier
