#include "render/wavelet_footprints.h"

#include <cmath>
#include <new>
#include <string>

#include "base/error.h"
#include "render/footprint_plan.h"
#include "render/picture.h"

namespace vol::render {

struct WaveletFootprints::State {
  FootprintPicture picture;
  RenderOptions options;
  FootprintReport report;
  std::vector<std::int32_t> covers;  ///< footprints over each pixel, once counted
};

WaveletFootprints::WaveletFootprints(const wavelet::Expansion& expansion, const Scene& scene,
                                     const RenderOptions& options, double error) {
  if (!(error > 0) || !std::isfinite(error))
    throw Error("footprint error: a positive share of the range is expected");
  require_valid(options);
  // Of sizes that memory does not hold an image says so, before the rays of its pixels are made.
  static_cast<void>(blank_image(options));
  const auto made = [&] {
    try {
      return FootprintPicture(expansion, scene.view, options.width, options.height);
    } catch (const std::bad_alloc&) {
      throw Error("the rays of " + std::to_string(options.width) + "x" + std::to_string(options.height) +
                  " pixels take more memory than there is; make the image smaller");
    }
  };
  state_ = std::make_unique<State>(State{made(), options, {}, {}});
  state_->report = plan_footprints(error, state_->picture);
}

WaveletFootprints::~WaveletFootprints() = default;

const FootprintReport& WaveletFootprints::report() const {
  return state_->report;
}

RenderResult WaveletFootprints::draw() {
  // Counting is no part of drawing, but where rays do it by the way.
  const bool count = state_->covers.empty() || !state_->picture.exact_bands.empty();
  const auto picture = state_->picture.values(count ? &state_->covers : nullptr);
  const auto& met = state_->covers;
  RenderResult result{blank_image(state_->options), {}, 0};
  std::size_t at = 0;
  for (int y = 0; y < state_->options.height; ++y) {
    for (int x = 0; x < state_->options.width; ++x, ++at) {
      if (state_->picture.misses(x, y)) continue;
      const auto value = static_cast<float>(picture[at]);
      if (!std::isfinite(value)) {
        throw Error("channel R reaches a value that float cannot hold; scale the volume");
      }
      for (int c = 0; c < 3; ++c) result.image.at(x, y, c) = value;
      result.image.at(x, y, 3) = 1;
      result.image.at(x, y, 4) = static_cast<float>(met[at]);
      ++result.counts.rays;
      result.counts.samples += met[at];
    }
  }
  result.error_estimate = state_->report.estimate;
  result.caster = "footprints";
  return result;
}

}  // namespace vol::render
