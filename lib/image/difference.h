#pragma once
#include <string>
#include <vector>

#include "image/image.h"
#include "image/metrics.h"

namespace vol::image {

enum class DifferenceKind {
  absolute,  ///< |tested - reference|
  signed_    ///< tested - reference
};

/// The difference of two images, one channel a pair, named as the pair. Equal infinities differ by 0. The
/// images must have one size, as for compare().
[[nodiscard]] Image difference(const Image& tested, const Image& reference,
                               const std::vector<ChannelPair>& channels, DifferenceKind kind);

/// Largest finite magnitude in a difference picture; 0 where there is none.
[[nodiscard]] double largest_magnitude(const Image& difference);

/// A difference picture in false colours (R, G, B, linear): a pixel shows the channel whose difference is
/// largest in magnitude. Absolute: black at 0 over purple and orange to light yellow at `scale` (nine points
/// of matplotlib's inferno, CC0). Signed: blue at -scale over white to red at +scale (ColorBrewer's RdBu).
/// Beyond the scale the end's colour; NaN is green. `scale` > 0.
[[nodiscard]] Image false_colour(const Image& difference, double scale, DifferenceKind kind);

/// One channel of a picture in false colours, its largest magnitude as the scale's end; with the picture's
/// attributes. \throws vol::Error where there is no such channel
struct ChannelInColours {
  Image image;
  double largest = 0;
};
[[nodiscard]] ChannelInColours channel_in_false_colours(const Image& picture, const std::string& channel);

}  // namespace vol::image
