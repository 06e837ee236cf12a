#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "camera/camera.h"
#include "curvilinear/phantom.h"
#include "curvilinear/ray_solids.h"
#include "curvilinear/sheets.h"

namespace vol::curvilinear {

/// Relative errors of optical depth over the pixels whose chord exceeds a tenth of the longest.
struct ChordErrors {
  double rms = 0, largest = 0, mean = 0;
  int pixels = 0;
};

/// A homogeneous medium in a phantom grid as a camera sees it, with the length of every pixel's ray inside
/// the grid's tricubic solids, by SolidRays.
class Homogeneous {
 public:
  Homogeneous(std::string_view phantom, const Dims& dims, const camera::View& view, int size)
      : grid_(make_phantom(phantom, dims, "constant", 1)),
        camera_(view, grid_.bounds().centre(), grid_.bounds().size().maxCoeff(), size, size),
        values_{std::vector<double>(grid_.blocks[0].points.size(), 0.0)},
        lengths_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size)) {
    const SolidRays rays(grid_, values_, CellKind::tricubic, 1);
    parallel_for(0, size, 1, [&](std::int64_t top, std::int64_t bottom) {
      RayScratch scratch;
      std::vector<RaySegment> segments;
      for (std::int64_t y = top; y < bottom; ++y) {
        for (int x = 0; x < size; ++x) {
          rays.segments(camera_.ray(x + 0.5, static_cast<double>(y) + 0.5),
                        -std::numeric_limits<double>::infinity(), scratch, segments);
          double& length = lengths_[static_cast<std::size_t>(y * size + x)];
          for (const RaySegment& s : segments) length += s.t1 - s.t0;
        }
      }
    });
    longest_ = *std::max_element(lengths_.begin(), lengths_.end());
  }

  /// Physical: optical depth 2 along the longest chord. Layers: 2 for as many cells as the grid's longest
  /// axis has.
  [[nodiscard]] SheetResult draw(Thickness thickness, double throttle) const {
    SheetOptions options;
    options.thickness = thickness;
    options.throttle = throttle;
    const Dims cells = grid_.blocks[0].cells();
    const auto most = static_cast<double>(*std::max_element(cells.begin(), cells.end()));
    const double depth = thickness == Thickness::physical ? kDepth : kDepth / most;
    const transfer::TransferFunction medium({{0, Vec3(1, 1, 1)}}, {{0, -std::expm1(-depth)}});
    return draw_sheets(grid_, values_, camera_, medium, longest_, options);
  }

  /// By layers, opacity follows no length: against the extinction that fits best, by least squares of the
  /// relative errors; what is left is the glow.
  [[nodiscard]] ChordErrors errors(const image::Image& image, Thickness thickness) const {
    std::vector<double> ratios;  // of optical depth to length
    for (std::size_t n = 0; n < lengths_.size(); ++n) {
      if (lengths_[n] <= 0.1 * longest_) continue;
      ratios.push_back(-std::log1p(-static_cast<double>(image.pixels[n * image.channels.size() + 3])) /
                       lengths_[n]);
    }
    double extinction = kDepth / longest_;
    if (thickness == Thickness::layers) {
      // sum (q / k - 1)^2 is least at k = sum q^2 / sum q.
      double squares = 0, sum = 0;
      for (const double q : ratios) {
        squares += q * q;
        sum += q;
      }
      extinction = squares / sum;
    }
    ChordErrors found;
    for (const double q : ratios) {
      const double e = q / extinction - 1;
      found.rms += e * e;
      found.mean += e;
      if (std::abs(e) > std::abs(found.largest)) found.largest = e;
    }
    found.pixels = static_cast<int>(ratios.size());
    found.rms = std::sqrt(found.rms / found.pixels);
    found.mean /= found.pixels;
    return found;
  }

 private:
  static constexpr double kDepth = 2;
  Grid grid_;
  camera::Camera camera_;
  std::vector<std::vector<double>> values_;
  std::vector<double> lengths_;
  double longest_ = 0;
};

}  // namespace vol::curvilinear
