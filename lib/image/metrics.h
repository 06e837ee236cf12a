#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace vol::image {

/// One channel of the picture under test and the channel of the reference it is held against.
struct ChannelPair {
  std::string name;
  int tested;     ///< index into the tested image's channels
  int reference;  ///< index into the reference's channels
};

struct ErrorOptions {
  double peak =
      1;  ///< largest signal: 1, or the maximum of the reference where that is not 1 (x-ray). > 0, finite
  bool ssim = true;  ///< the structural similarity too; without it the rest takes a third of the time
};

/// Error of one channel, or of several together. With t the tested and r the reference value of a pixel:
///   mse = mean (t - r)^2,  mae = mean |t - r|,  maximum = max |t - r|, over all pixels, unclamped.
/// Together: mean of the channels' mse, mae and ssim; the largest maximum; sums of the counts.
///
/// Infinity and NaN are not passed over. Equal infinities differ by 0; infinities of opposite sign, or an
/// infinity and a number, by infinity. One NaN in either image makes mse, mae and maximum NaN (x, y: the
/// first one). The structural similarity of a channel that holds NaN or infinity is undefined: NaN.
struct ChannelError {
  std::string name;
  double mse = 0;
  double mae = 0;
  double maximum = 0;
  int maximum_x = -1;  ///< the first pixel, row by row, that has the maximum; -1 where the maximum is 0
  int maximum_y = -1;
  std::string maximum_channel;  ///< the channel it is in
  double ssim = 0;              ///< NaN: undefined, or not asked for
  std::int64_t nan_tested = 0;  ///< values that are NaN in the tested image
  std::int64_t nan_reference = 0;
  std::int64_t infinite_tested = 0;  ///< values that are infinite in the tested image
  std::int64_t infinite_reference = 0;
};

struct ImageError {
  std::vector<ChannelError> channels;
  ChannelError all;
  double peak = 1;
};

/// sqrt(mse)
[[nodiscard]] double rmse(const ChannelError& error);
/// Root mean square on the byte scale, rmse 255 / peak, and its square.
[[nodiscard]] double rmse_byte(const ChannelError& error, double peak);
[[nodiscard]] double mse_byte(const ChannelError& error, double peak);
/// 10 log10(peak^2 / mse), in dB: +infinity for equal images.
[[nodiscard]] double psnr(const ChannelError& error, double peak);

/// Errors of `tested` against `reference`, channel by channel and together.
///
/// The structural similarity is that of Wang, Bovik, Sheikh & Simoncelli, Image quality assessment: from
/// error visibility to structural similarity, IEEE TIP 13 (2004): windows of 11 x 11 pixels, Gaussian of
/// sigma 1.5, K1 0.01, K2 0.03, mean over the windows that lie wholly in the image; undefined (NaN) where the
/// image is narrower or lower than 11 pixels. See ssim.h for how it is computed and how exactly.
///
/// Runs on the process's threads; every figure is the same, bit for bit, for any number of them and on any
/// instruction set. Sums are compensated: relative error below 1e-14. Throws vol::Error where the sizes
/// differ (naming both), a channel does not exist, or the peak is not a positive number.
[[nodiscard]] ImageError compare(const Image& tested, const Image& reference,
                                 const std::vector<ChannelPair>& channels, const ErrorOptions& options = {});

/// The colour of an image: R, G, B, or Y three times. Throws vol::Error where there is neither.
[[nodiscard]] std::array<int, 3> colour_channels(const Image& image);

/// The same image with its colour over a background: C + (1 - A) background, A then 1. Without A, or over
/// black, it is returned as it came. Other channels stay. `background`: linear R, G, B; a grey image (Y)
/// takes a grey background only.
[[nodiscard]] Image composited(Image image, const std::array<double, 3>& background);

/// Largest finite value of some channels; -infinity where there is none.
[[nodiscard]] double largest_value(const Image& image, const std::vector<int>& channels);

}  // namespace vol::image
