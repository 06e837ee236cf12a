#pragma once
#include <span>

#include "render/ray_box.h"
#include "render/raycast.h"
#include "wavelet/expansion.h"

namespace vol::render {

/// What a picture of an expansion costs, beyond RenderCounts, whose samples are the terms that rays met.
struct WaveletCounts {
  std::int64_t pieces = 0;  ///< polynomial pieces integrated
};

/// X-ray pictures of a wavelet expansion, never rebuilding its volume: the integral of f in value times world
/// length along every ray within the field's box, as vol-raycast's xray, exact but for rounding
/// (wavelet::line_integral). A ray visits only the terms whose support it meets, by the bands' trees. R = G =
/// B the integral, A = 1 where the ray meets the box, samples the terms met, depth infinite.
///
/// Refers to the expansion, which must live longer.
class WaveletXray {
 public:
  explicit WaveletXray(const wavelet::Expansion& expansion) : expansion_(expansion) {}

  /// Of options, width and height count. \throws vol::Error on a pixel that float cannot hold
  [[nodiscard]] RenderResult draw(const Scene& scene, const RenderOptions& options,
                                  WaveletCounts* counts = nullptr) const;

  /// One ray: adds the number of terms met and of their pieces.
  [[nodiscard]] double integral(const camera::Ray& ray, const Chord& chord, std::int64_t& terms,
                                std::int64_t& pieces) const;
  /// Of some bands only.
  [[nodiscard]] double integral(const camera::Ray& ray, const Chord& chord,
                                std::span<const wavelet::Band* const> bands, std::int64_t& terms,
                                std::int64_t& pieces) const;

 private:
  const wavelet::Expansion& expansion_;
};

}  // namespace vol::render
