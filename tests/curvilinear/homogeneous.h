#pragma once
#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "camera/camera.h"
#include "curvilinear/phantom.h"
#include "curvilinear/ray_solids.h"
#include "curvilinear/sheets.h"

namespace vol::curvilinear {

/// A homogeneous medium in a phantom grid, as a view of it sees it: opacity 1 - exp(-L) where light goes a
/// length L inside.
struct Homogeneous {
  Grid grid;
  std::vector<std::vector<double>> values;
  camera::Camera camera;
  std::vector<double> lengths;  ///< of the pixels' rays, by SolidRays
  double longest = 0;

  Homogeneous(const char* phantom, const Dims& dims, camera::View view, int size)
      : grid(make_phantom(phantom, dims, "constant", 1)),
        camera(view, grid.bounds().centre(), grid.bounds().size().maxCoeff(), size, size),
        lengths(static_cast<std::size_t>(size) * static_cast<std::size_t>(size)) {
    for (const Block& block : grid.blocks) values.emplace_back(block.points.size(), 0.0);
    const SolidRays rays(grid, values, CellKind::tricubic, 1);
    parallel_for(0, size, 1, [&](std::int64_t top, std::int64_t bottom) {
      RayScratch scratch;
      std::vector<RaySegment> segments;
      for (std::int64_t y = top; y < bottom; ++y) {
        for (int x = 0; x < size; ++x) {
          rays.segments(camera.ray(x + 0.5, static_cast<double>(y) + 0.5),
                        -std::numeric_limits<double>::infinity(), scratch, segments);
          double& length = lengths[static_cast<std::size_t>(y * size + x)];
          for (const RaySegment& s : segments) length += s.t1 - s.t0;
        }
      }
    });
    for (const double l : lengths) longest = std::max(longest, l);
  }

  [[nodiscard]] SheetResult draw(Thickness thickness, double throttle) const {
    SheetOptions options;
    options.thickness = thickness;
    options.throttle = throttle;
    // Opacity 1 - 1/e a reference length, or a cell.
    const transfer::TransferFunction medium({{0, Vec3(1, 1, 1)}}, {{0, -std::expm1(-1.0)}});
    return draw_sheets(grid, values, camera, medium, reference_length(), options);
  }
  /// Optical depth of the longest chord is 2.
  [[nodiscard]] double reference_length() const { return longest / 2; }
};

/// Relative errors of optical depth over the pixels whose chord exceeds a tenth of the longest.
struct ChordErrors {
  double rms = 0, largest = 0, mean = 0;
  int pixels = 0, x = 0, y = 0;  ///< where the largest is
};

/// \param per_length  optical depth that a unit of length has; 0: that which fits best (least squares of the
/// relative errors), for sheets whose opacity follows no length
inline ChordErrors chord_errors(const Homogeneous& medium, const image::Image& image, double per_length) {
  ChordErrors found;
  const auto each = [&](const auto& visit) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const double l = medium.lengths[static_cast<std::size_t>(y * image.width + x)];
        if (l <= 0.1 * medium.longest) continue;
        visit(x, y, -std::log1p(-static_cast<double>(image.at(x, y, 3))) / l);
      }
    }
  };
  if (per_length == 0) {
    // Least squares of q / k - 1 over all q: k = sum q^2 / sum q.
    double squares = 0, sum = 0;
    each([&](int, int, double q) {
      squares += q * q;
      sum += q;
    });
    per_length = squares / sum;
  }
  each([&](int x, int y, double q) {
    const double e = q / per_length - 1;
    found.rms += e * e;
    found.mean += e;
    ++found.pixels;
    if (std::abs(e) > std::abs(found.largest)) {
      found.largest = e;
      found.x = x;
      found.y = y;
    }
  });
  found.rms = std::sqrt(found.rms / found.pixels);
  found.mean /= found.pixels;
  return found;
}

}  // namespace vol::curvilinear
