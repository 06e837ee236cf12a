#include "curvilinear/sheets_within_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/rng.h"
#include "curvilinear/larger_error.h"

namespace vol::curvilinear {
namespace {

using render::PixelPosition;

constexpr int kError = 5;           ///< the channel
constexpr double kRayShare = 0.25;  ///< of max_error, for rays; chosen
constexpr float kFloat = 6e-8F;     ///< rounding of a pixel's channels
/// Solids are drawn to a tenth of the throttle's pixels, merged ones to as much again.
constexpr double kPositions = 0.2;
/// Below it sheets' float arithmetic would be seen, some hundred roundings of it; chosen.
constexpr double kLeastForSheets = 2e-5;
/// Where the search for a throttle starts and ends. Chosen: halving mends a start that is too coarse, at the
/// cost of pictures drawn in vain; one that is too fine nothing mends.
constexpr double kLeastThrottle = 0.25, kMostThrottle = 16, kThrottleAnError = 1000;
/// On what a picture of twice the throttle differs by. Chosen: an error of order 2 in the throttle would need
/// 1 / 3 of it, one of order 1 just it.
constexpr float kSafety = 2;
/// Of the pixels, for which halving the throttle is taken to cost more than rays do; chosen.
constexpr double kMostRedrawn = 0.125;

class WithinError {
 public:
  WithinError(const SolidRays& rays, const std::vector<std::vector<double>>& values,
              const render::Scene& scene, int width, int height, const SheetOptions& options,
              double max_error)
      : rays_(rays),
        values_(values),
        scene_(scene),
        options_(options),
        max_error_(max_error),
        camera_(scene.view, rays.grid().bounds().centre(), rays.grid().bounds().size().maxCoeff(), width,
                height) {
    ray_scene_ = scene;
    ray_scene_.reference_length *= options.thinned_by;  // the same extinction
    ray_options_.width = width;
    ray_options_.height = height;
    ray_options_.tolerance = kRayShare * max_error;
    options_.thickness = Thickness::physical;
    options_.merge = options_.along_rays = true;
  }

  WithinErrorResult draw() {
    draw_by_sheets();
    by_rays_.assign(
        static_cast<std::size_t>(camera_.image_width()) * static_cast<std::size_t>(camera_.image_height()),
        false);
    redraw_above();
    bool passed = false;
    for (int n = 0; n < kMostChecks && !passed; ++n) passed = check();
    if (!passed) {
      for (const auto& [x, y] : of_sheets()) result_.image.at(x, y, kError) = kUnknown;
      redraw_above();
    }
    if (of_sheets().empty()) forget_sheets();
    for (const auto& [x, y] : all())
      result_.error_estimate = larger_error(result_.error_estimate, double{result_.image.at(x, y, kError)});
    result_.counts.ray_samples = ray_counts_.samples;
    return std::move(result_);
  }

 private:
  static constexpr float kUnknown = std::numeric_limits<float>::infinity();
  const SolidRays& rays_;
  const std::vector<std::vector<double>>& values_;
  const render::Scene& scene_;
  render::Scene ray_scene_;
  SheetOptions options_;
  double max_error_;
  camera::Camera camera_;
  render::RenderOptions ray_options_;
  render::RenderCounts ray_counts_;
  std::vector<bool> by_rays_;
  WithinErrorResult result_;
  Rng random_{1};

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.image_width()) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::vector<PixelPosition> all() const {
    std::vector<PixelPosition> found;
    for (std::int32_t y = 0; y < camera_.image_height(); ++y) {
      for (std::int32_t x = 0; x < camera_.image_width(); ++x) found.push_back({x, y});
    }
    return found;
  }
  /// Those of sheets whose estimate is asked for.
  template <class Asked>
  [[nodiscard]] std::vector<PixelPosition> of_sheets_where(const Asked& asked) const {
    std::vector<PixelPosition> found = all();
    std::erase_if(found, [&](const PixelPosition& p) {
      return by_rays_[at(p.x, p.y)] || !asked(result_.image.at(p.x, p.y, kError));
    });
    return found;
  }

  [[nodiscard]] std::vector<PixelPosition> of_sheets() const {
    return of_sheets_where([](float) { return true; });
  }
  /// Pixels that something drawn, at this throttle, may be off by; for all that looks around a pixel.
  [[nodiscard]] int reach() const {
    return std::max(1, static_cast<int>(std::ceil(kPositions * options_.throttle)));
  }
  /// Over the pixels of the picture within reach of one.
  template <class Visit>
  void around(int x, int y, const Visit& visit) const {
    const int r = reach();
    for (int v = std::max(0, y - r); v < std::min(camera_.image_height(), y + r + 1); ++v) {
      for (int u = std::max(0, x - r); u < std::min(camera_.image_width(), x + r + 1); ++u) visit(u, v);
    }
  }

  void draw_by_sheets() {
    if (max_error_ < kLeastForSheets) return draw_nothing();
    double throttle = std::clamp(kThrottleAnError * max_error_, kLeastThrottle, kMostThrottle);
    for (;; throttle /= 2) {
      const SheetResult coarse = sheets(2 * throttle, CellOrder::depth, false);
      result_.counts.sheets = coarse.counts;
      if (seen(coarse.image) < coarse.counts.cells) return draw_nothing();
      SheetResult fine = sheets(throttle, CellOrder::faces, true);
      estimate(fine.image, coarse.image);
      result_.image = std::move(fine.image);
      result_.counts.sheets = fine.counts;
      result_.throttle = throttle;
      std::int64_t above = 0;
      for (const auto& [x, y] : all()) above += !(result_.image.at(x, y, kError) <= max_error_);
      if (static_cast<double>(above) <= kMostRedrawn * static_cast<double>(seen(result_.image)) ||
          throttle < 2 * kLeastThrottle)
        return;
    }
  }
  /// Nothing in the picture is by them: neither are the figures.
  void forget_sheets() {
    result_.throttle = 0;
    result_.counts.sheets = {};
    result_.last_checked = 0;
    result_.largest_checked = 0;
  }
  /// All is for rays.
  void draw_nothing() {
    forget_sheets();
    result_.image =
        image::Image(camera_.image_width(), camera_.image_height(), {"R", "G", "B", "A", "samples", "error"});
    for (const auto& [x, y] : all()) result_.image.at(x, y, kError) = kUnknown;
  }
  [[nodiscard]] std::int64_t seen(const image::Image& image) const {
    std::int64_t count = 0;
    for (const auto& [x, y] : all()) count += image.at(x, y, 4) > 0;
    return count;
  }
  [[nodiscard]] SheetResult sheets(double throttle, CellOrder order, bool sensitivity) {
    options_.throttle = throttle;
    options_.order = order;
    options_.sensitivity = sensitivity;
    SheetResult drawn =
        draw_sheets(rays_.grid(), values_, camera_, scene_.transfer, scene_.reference_length, options_);
    result_.counts.samples += drawn.counts.samples + drawn.counts.off_samples;
    return drawn;
  }

  /// Into the channel `error`, which has what tolerances of values do.
  void estimate(image::Image& fine, const image::Image& coarse) const {
    const int width = camera_.image_width(), height = camera_.image_height();
    std::vector<float> change(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (const auto& [x, y] : all()) {
      float most = 0;
      for (int c = 0; c < 4; ++c) most = larger_error(most, std::abs(fine.at(x, y, c) - coarse.at(x, y, c)));
      change[at(x, y)] = kSafety * most;
    }
    for (const auto& [x, y] : all()) {
      float& error = fine.at(x, y, kError);
      around(x, y, [&](int u, int v) { error = larger_error(error, change[at(u, v)]); });
      for (int distance = 1; distance <= reach(); ++distance) {
        const auto moved =
            static_cast<float>(std::sqrt(std::min(1.0, kPositions * options_.throttle / distance)));
        error = larger_error(error, moved * bend(fine, x, y, distance));
      }
    }
  }
  /// The largest second difference across a pixel at a distance, along rows, columns and diagonals. At a
  /// silhouette light grows as the root of the distance from it.
  [[nodiscard]] static float bend(const image::Image& image, int x, int y, int distance) {
    const auto inside = [&](int u, int v) { return u >= 0 && u < image.width && v >= 0 && v < image.height; };
    float most = 0;
    for (const auto& [right, down] : {std::pair(1, 0), {0, 1}, {1, 1}, {1, -1}}) {
      const int dx = right * distance, dy = down * distance;
      if (!inside(x - dx, y - dy) || !inside(x + dx, y + dy)) continue;
      for (int c = 0; c < 4; ++c) {
        most = larger_error(most, std::abs(image.at(x - dx, y - dy, c) - 2 * image.at(x, y, c) +
                                           image.at(x + dx, y + dy, c)));
      }
    }
    return most;
  }

  void redraw_above() {
    const std::vector<PixelPosition> above =
        of_sheets_where([&](float error) { return !(error <= max_error_); });
    result_.counts.redrawn += static_cast<std::int64_t>(above.size());
    (void)take_rays(above);
  }
  /// Draws pixels by rays. \returns by how much each was off
  std::vector<double> take_rays(const std::vector<PixelPosition>& of) {
    const std::vector<render::Pixel> found = cast_pixels(rays_, ray_scene_, ray_options_, of, ray_counts_);
    std::vector<double> off(of.size(), 0);
    for (std::size_t n = 0; n < of.size(); ++n) {
      const render::Pixel& p = found[n];
      const float channels[4] = {static_cast<float>(p.colour[0]), static_cast<float>(p.colour[1]),
                                 static_cast<float>(p.colour[2]), static_cast<float>(p.alpha)};
      for (int c = 0; c < 4; ++c) {
        float& here = result_.image.at(of[n].x, of[n].y, c);
        off[n] = larger_error(off[n], std::abs(static_cast<double>(here) - channels[c]));
        here = channels[c];
      }
      result_.image.at(of[n].x, of[n].y, kError) = static_cast<float>(p.error) + kFloat;
      by_rays_[at(of[n].x, of[n].y)] = true;
    }
    result_.counts.rays += static_cast<std::int64_t>(of.size());
    return off;
  }

  /// Pixels of sheets at random against their rays. \returns whether none is off by more than it may; else
  /// estimates are doubled, and what is then above is drawn by rays
  bool check() {
    std::vector<PixelPosition> left = of_sheets();
    // Where nothing is seen near by there is nothing to be missed.
    std::erase_if(left, [&](const PixelPosition& p) {
      bool seen = false;
      around(p.x, p.y, [&](int u, int v) { seen |= result_.image.at(u, v, 4) > 0; });
      return !seen;
    });
    constexpr std::size_t kShare = 64;
    const std::size_t count = std::min(left.size(), std::max<std::size_t>(kChecked, left.size() / kShare));
    for (std::size_t n = 0; n < count; ++n) std::swap(left[n], left[n + random_.below(left.size() - n)]);
    left.resize(count);
    const std::vector<double> off = take_rays(left);
    result_.largest_checked = off.empty() ? 0 : *std::max_element(off.begin(), off.end());
    result_.last_checked = static_cast<std::int64_t>(count);
    result_.counts.checked += static_cast<std::int64_t>(count);
    const auto missed = std::count_if(off.begin(), off.end(), [&](double e) { return !(e <= max_error_); });
    result_.counts.missed += missed;
    if (missed == 0) return true;
    for (const auto& [x, y] : of_sheets()) {
      float& error = result_.image.at(x, y, kError);
      error = larger_error(2 * error, static_cast<float>(max_error_ / 2));  // one of 0 as well
    }
    redraw_above();
    return false;
  }
};

}  // namespace

WithinErrorResult draw_within_error(const SolidRays& rays, const std::vector<std::vector<double>>& values,
                                    const render::Scene& scene, int width, int height,
                                    const SheetOptions& options, double max_error) {
  if (!(max_error > 0 && std::isfinite(max_error)))
    throw Error("the largest error must be a positive number");
  if (scene.model != render::Model::composite || scene.shading)
    throw Error("sheets are drawn of a composite scene without shading");
  const std::vector<Block>& blocks = rays.grid().blocks;
  if (values.size() != blocks.size()) throw Error("sheets need values for every block");
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    if (values[b].size() != blocks[b].points.size())
      throw Error("sheets need one value a point of each block");
    if (!std::all_of(values[b].begin(), values[b].end(), [](double f) { return std::isfinite(f); }))
      throw Error("values must be finite: no error can be told from others");
  }
  return WithinError(rays, values, scene, width, height, options, max_error).draw();
}

}  // namespace vol::curvilinear
