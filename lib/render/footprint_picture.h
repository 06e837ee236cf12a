#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/axis_products.h"
#include "render/footprint_splats.h"
#include "render/octant_cells.h"
#include "render/wavelet_xray.h"

namespace vol::render {

/// What is drawn how: plan_footprints() decides it (footprint_plan.h), values() carries it out. Refers to the
/// expansion.
struct FootprintPicture {
  const wavelet::Expansion& expansion;
  int width = 0, height = 0;
  ParallelView view;
  WaveletXray xray;
  bool in_float = false;  ///< terms are added in float

  std::vector<PixelRow> rays;
  FaceWindows windows;
  std::vector<std::array<int, 2>> exact_pixels;  ///< that no footprint can draw: (x, y), each once

  std::vector<OctantCells> cells;
  std::optional<AxisProducts> products;
  std::vector<FootprintGroup> groups;
  std::vector<const wavelet::Band*> exact_bands;

  /// The rays of every pixel and the windows of the box's faces; nothing to draw yet.
  FootprintPicture(const wavelet::Expansion& expansion, const camera::View& view, int width, int height);

  /// More exact pixels. Each is kept once: pixels are drawn in parallel.
  void draw_exactly(const std::vector<std::array<int, 2>>& pixels);
  [[nodiscard]] bool misses(int x, int y) const {
    return rays[static_cast<std::size_t>(y)].half[static_cast<std::size_t>(x)] < 0;
  }
  /// Integrals within the box, row after row; 0 where a ray misses it.
  /// \param met  if given, how many footprints' rectangles hold each pixel
  [[nodiscard]] std::vector<double> values(std::vector<std::int32_t>* met) const;

 private:
  struct Rows;
  void add_look_ups(const FootprintGroup& group, const FootprintPart& part, const Rows& rows) const;
  void add_exact_cuts(const FootprintGroup& group, const FootprintPart& part, const Rows& rows) const;
  void add_without_planes(const Rows& rows) const;
};

}  // namespace vol::render
