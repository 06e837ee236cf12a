#include "curvilinear/sheets_within_error.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/rng.h"

namespace vol::curvilinear {
namespace {

using render::PixelPosition;

constexpr int kError = 5;                 ///< the channel
constexpr double kRayShare = 0.25;        ///< of max_error, for rays
constexpr float kFloat = 6e-8F;           ///< rounding of a pixel's channels
constexpr double kLeastForSheets = 2e-5;  ///< below it, sheets' float arithmetic would be seen
constexpr double kLeastThrottle = 0.25, kMostThrottle = 16, kThrottleAnError = 1000;
constexpr float kSafety = 2;  ///< on what a picture of twice the throttle differs by
constexpr double kMostRedrawn = 0.125;
constexpr int kMostChecks = 4;

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
      for (auto& [x, y] : pixels([](float) { return true; })) result_.image.at(x, y, kError) = kUnknown;
      redraw_above();
    }
    for (const auto& [x, y] : all())
      result_.error_estimate = std::max(result_.error_estimate, double{result_.image.at(x, y, kError)});
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
  [[nodiscard]] std::vector<PixelPosition> pixels(const Asked& asked) const {
    std::vector<PixelPosition> found = all();
    std::erase_if(found, [&](const PixelPosition& p) {
      return by_rays_[at(p.x, p.y)] || !asked(result_.image.at(p.x, p.y, kError));
    });
    return found;
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
  /// All is for rays.
  void draw_nothing() {
    result_.image =
        image::Image(camera_.image_width(), camera_.image_height(), {"R", "G", "B", "A", "samples", "error"});
    for (const auto& [x, y] : all()) result_.image.at(x, y, kError) = kUnknown;
  }
  [[nodiscard]] std::int64_t seen(const image::Image& image) const {
    std::int64_t count = 0;
    for (const auto& [x, y] : all()) count += image.at(x, y, 4) > 0;
    return count;
  }
  [[nodiscard]] SheetResult sheets(double throttle, CellOrder order, bool bounds) {
    options_.throttle = throttle;
    options_.order = order;
    options_.bounds = bounds;
    return draw_sheets(rays_.grid(), values_, camera_, scene_.transfer, scene_.reference_length, options_);
  }

  /// Into the channel `error`, which has what tolerances of values do.
  void estimate(image::Image& fine, const image::Image& coarse) const {
    const int width = camera_.image_width(), height = camera_.image_height();
    // At a silhouette light grows as the root of the distance from it; solids are drawn to a tenth of the
    // throttle's pixels, merged ones to as much again.
    constexpr double kPositions = 0.2;
    const auto moved = static_cast<float>(std::sqrt(std::min(1.0, kPositions * options_.throttle)));
    std::vector<float> change(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (const auto& [x, y] : all()) {
      float most = 0;
      for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(fine.at(x, y, c) - coarse.at(x, y, c)));
      change[at(x, y)] = kSafety * most;
    }
    for (const auto& [x, y] : all()) {
      float& error = fine.at(x, y, kError);
      for (int v = std::max(0, y - 1); v < std::min(height, y + 2); ++v) {
        for (int u = std::max(0, x - 1); u < std::min(width, x + 2); ++u)
          error = std::max(error, change[at(u, v)]);
      }
      error = std::max(error, moved * bend(fine, x, y));
    }
  }
  /// The largest second difference across a pixel, along rows, columns and diagonals.
  [[nodiscard]] static float bend(const image::Image& image, int x, int y) {
    const auto inside = [&](int u, int v) { return u >= 0 && u < image.width && v >= 0 && v < image.height; };
    float most = 0;
    for (const auto& [dx, dy] : {std::pair(1, 0), {0, 1}, {1, 1}, {1, -1}}) {
      if (!inside(x - dx, y - dy) || !inside(x + dx, y + dy)) continue;
      for (int c = 0; c < 4; ++c) {
        most = std::max(most, std::abs(image.at(x - dx, y - dy, c) - 2 * image.at(x, y, c) +
                                       image.at(x + dx, y + dy, c)));
      }
    }
    return most;
  }

  void redraw_above() {
    const std::vector<PixelPosition> above = pixels([&](float error) { return !(error <= max_error_); });
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
        off[n] = std::max(off[n], std::abs(static_cast<double>(here) - channels[c]));
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
    std::vector<PixelPosition> left = pixels([](float) { return true; });
    // Where nothing is seen near by there is nothing to be missed.
    std::erase_if(left, [&](const PixelPosition& p) {
      for (int v = std::max(0, p.y - 1); v < std::min(camera_.image_height(), p.y + 2); ++v) {
        for (int u = std::max(0, p.x - 1); u < std::min(camera_.image_width(), p.x + 2); ++u) {
          if (result_.image.at(u, v, 4) > 0) return false;
        }
      }
      return true;
    });
    constexpr std::size_t kShare = 64;
    const std::size_t count = std::min(left.size(), std::max<std::size_t>(kChecked, left.size() / kShare));
    for (std::size_t n = 0; n < count; ++n) std::swap(left[n], left[n + random_.below(left.size() - n)]);
    left.resize(count);
    const std::vector<double> off = take_rays(left);
    result_.largest_checked = off.empty() ? 0 : *std::max_element(off.begin(), off.end());
    result_.counts.checked += static_cast<std::int64_t>(count);
    const auto missed = std::count_if(off.begin(), off.end(), [&](double e) { return !(e <= max_error_); });
    result_.counts.missed += missed;
    if (missed == 0) return true;
    for (const auto& [x, y] : pixels([](float) { return true; })) result_.image.at(x, y, kError) *= 2;
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
  return WithinError(rays, values, scene, width, height, options, max_error).draw();
}

}  // namespace vol::curvilinear
