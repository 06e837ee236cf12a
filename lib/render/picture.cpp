#include "render/picture.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "render/refinement.h"

namespace vol::render {
namespace {

float as_float(double value, const char* channel) {
  const auto narrow = static_cast<float>(value);
  if (!std::isfinite(narrow)) {
    throw Error(std::string("channel ") + channel +
                " reaches a value that float cannot hold; scale the volume");
  }
  return narrow;
}

struct Partial {
  RenderCounts counts;
  double error = 0;
};

/// One pixel after another, from any thread.
struct Painter {
  const RayBox& box;
  const camera::Camera& camera;
  const RayCaster& cast;
  image::Image& image;
  const BesideCaster& beside;

  void paint(int x, int y, Partial& partial) const {
    const camera::Ray ray = camera.ray(x + 0.5, y + 0.5);
    const auto chord = box.chord(ray, camera.t_min());
    if (!chord && !beside) return;
    partial.counts.rays += chord.has_value();
    const std::int64_t samples_before = partial.counts.samples;
    const Pixel pixel = chord ? cast(ray, *chord, partial.counts) : beside(ray, partial.counts);
    static constexpr const char* kNames[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) image.at(x, y, c) = as_float(pixel.colour[c], kNames[c]);
    image.at(x, y, 3) = as_float(pixel.alpha, "A");
    image.at(x, y, 4) = static_cast<float>(partial.counts.samples - samples_before);
    image.at(x, y, 5) = static_cast<float>(pixel.depth);
    if (image.channels.size() > kErrorChannel)
      image.at(x, y, kErrorChannel) = static_cast<float>(pixel.error);
    partial.error = std::max(partial.error, pixel.error);
  }
};

void fold(Partial& sum, const Partial& p) {
  sum.counts += p.counts;
  sum.error = std::max(sum.error, p.error);
}

/// Pixels of a list.
Partial paint(const Painter& painter, std::span<const PixelPosition> pixels) {
  const auto some = [&](std::int64_t begin, std::int64_t end) {
    Partial partial;
    for (auto i = begin; i < end; ++i) {
      const PixelPosition& p = pixels[static_cast<std::size_t>(i)];
      painter.paint(p.x, p.y, partial);
    }
    return partial;
  };
  return parallel_reduce<Partial>(0, static_cast<std::int64_t>(pixels.size()), 16, some, fold);
}

}  // namespace

void require_valid(const RenderOptions& options) {
  if (options.width < 1 || options.height < 1) throw Error("image size is below 1 x 1");
  if (!(options.step > 0) || !std::isfinite(options.step)) throw Error("step is not a positive number");
  if (!(options.step_tolerance >= 0) || !std::isfinite(options.step_tolerance)) {
    throw Error("step tolerance is not a number >= 0");
  }
  if (options.step_tolerance > 0 && options.quadrature != Quadrature::trapezoid) {
    throw Error("step tolerance: trapezoid is the quadrature that has steps of adaptive length");
  }
  if (options.nodes < 1 || options.nodes > 3) throw Error("split takes 1, 2 or 3 Gauss nodes a piece");
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance)) {
    throw Error("tolerance is not a positive number");
  }
  if (!(options.max_error >= 0) || !std::isfinite(options.max_error)) {
    throw Error("largest error is not a positive number");
  }
  if (options.max_error > 0 && options.quadrature != Quadrature::split &&
      options.quadrature != Quadrature::reference) {
    throw Error("a bound on the error is kept by quadrature split alone");
  }
  if (!(options.termination >= 0 && options.termination < 1)) {
    throw Error("termination: a transmittance in [0, 1) is expected");
  }
}

double resolved_reference_length(const Scene& scene, double smallest_spacing) {
  if (scene.reference_length != 0) return scene.reference_length;
  if (smallest_spacing > 0) return smallest_spacing;
  throw Error("a field without a grid has no spacing: the scene needs a reference_length");
}

image::Image blank_image(const RenderOptions& options, image::Image spare) {
  std::vector<std::string> channels{"R", "G", "B", "A", "samples", "depth"};
  std::vector<float> pixel{0, 0, 0, 0, 0, std::numeric_limits<float>::infinity()};
  if (options.max_error > 0) {
    channels.emplace_back("error");
    pixel.push_back(0);
  }
  return {options.width, options.height, std::move(channels), pixel, std::move(spare)};
}

RenderResult draw(const volume::FieldBounds& bounds, const Scene& scene, const RenderOptions& options,
                  const RayCaster& cast, const BesideCaster& beside) {
  const RayBox box(bounds);
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), options.width,
                              options.height);
  RenderResult result{blank_image(options), {}, 0};
  const Painter painter{box, camera, cast, result.image, beside};
  const auto pixel_at = [&](int x, int y, Partial& partial) { painter.paint(x, y, partial); };
  Partial total;
  if (options.image_step == 1) {
    const auto row = [&](std::int64_t y0, std::int64_t y1) {
      Partial partial;
      for (auto y = static_cast<int>(y0); y < static_cast<int>(y1); ++y) {
        for (int x = 0; x < options.width; ++x) pixel_at(x, y, partial);
      }
      return partial;
    };
    total = parallel_reduce<Partial>(0, options.height, 1, row, fold);
  } else {
    cast_refined(result.image, options.image_step, options.image_tolerance,
                 [&](std::span<const PixelPosition> pixels) { fold(total, paint(painter, pixels)); });
  }
  result.counts = total.counts;
  result.error_estimate = total.error;
  return result;
}

void redraw(const volume::FieldBounds& bounds, const Scene& scene, std::span<const PixelPosition> pixels,
            const RayCaster& cast, RenderResult& result) {
  const RayBox box(bounds);
  const camera::Camera camera(scene.view, bounds.centre(), bounds.longest_edge(), result.image.width,
                              result.image.height);
  std::vector<float> samples;
  for (const PixelPosition& p : pixels) {
    result.image.at(p.x, p.y, 5) = std::numeric_limits<float>::infinity();
    samples.push_back(result.image.at(p.x, p.y, 4));
  }
  Partial total = paint({box, camera, cast, result.image, {}}, pixels);
  total.counts.rays = 0;  // they were counted when they were cast first
  for (std::size_t i = 0; i < pixels.size(); ++i) result.image.at(pixels[i].x, pixels[i].y, 4) += samples[i];
  result.counts += total.counts;
}

}  // namespace vol::render
