#include "render/max_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "render/picture.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

/// Pixels whose estimate is above a bound.
std::vector<PixelPosition> pixels_above(const image::Image& image, double bound) {
  std::vector<PixelPosition> above;
  for (std::int32_t y = 0; y < image.height; ++y) {
    for (std::int32_t x = 0; x < image.width; ++x) {
      if (!(double(image.at(x, y, kErrorChannel)) <= bound)) above.push_back({x, y});
    }
  }
  return above;
}

/// Infinite where a pixel has no estimate.
double largest_error(const image::Image& image) {
  const std::vector<PixelPosition> beyond = pixels_above(image, std::numeric_limits<double>::max());
  if (!beyond.empty()) return std::numeric_limits<double>::infinity();
  double most = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) most = std::max(most, double(image.at(x, y, kErrorChannel)));
  }
  return most;
}

/// Of an X-ray or a maximum: errors over the largest value of the picture.
void make_relative(image::Image& image) {
  float largest = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) largest = std::max(largest, std::abs(image.at(x, y, 0)));
  }
  if (!(largest > 0)) return;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) image.at(x, y, kErrorChannel) /= largest;
  }
}

}  // namespace

RenderOptions within_error(const RenderOptions& options) {
  if (!(options.max_error > 0)) throw Error("the largest error must be a positive number");
  RenderOptions adaptive = options;
  adaptive.quadrature = Quadrature::split;
  adaptive.image_step = 1;
  adaptive.tolerance = kReferenceShare * options.max_error;
  return adaptive;
}

RenderResult cast_within_error(const PacketScene& prepared, const camera::View& view) {
  const RenderOptions& options = prepared.options();
  if (!(options.max_error > 0)) throw Error("the scene was not prepared for a largest error");
  Scene scene = prepared.scene();
  scene.view = view;
  RenderResult result = prepared.cast(view);
  if (scene.model != Model::composite) {  // the reference's already
    make_relative(result.image);
    result.error_estimate = largest_error(result.image);
    return result;
  }
  const std::vector<PixelPosition> above = pixels_above(result.image, options.max_error);
  if (!above.empty()) {
    const volume::Volume& volume = prepared.volume();
    redraw(volume::field_bounds(volume.geometry()), scene, above, reference_caster(volume, scene, options),
           result);
  }
  result.error_estimate = largest_error(result.image);
  return result;
}

RenderResult raycast_within_error(const PacketVolume& volume, const Scene& scene,
                                  const RenderOptions& options) {
  return cast_within_error(PacketScene(volume, scene, within_error(options)), scene.view);
}

}  // namespace vol::render
