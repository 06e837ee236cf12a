#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/options.h"
#include "render/ray_box.h"
#include "volume/grid_geometry.h"

namespace vol::render {

/// The rays of one row of a parallel picture, in index space.
struct PixelRow {
  std::array<std::vector<double>, 3> middle;  ///< of the chord within the volume's box
  std::vector<double> half;                   ///< of its world length; -1 where the ray misses
  std::array<std::vector<std::int8_t>, 2>
      face;  ///< axis of the face of entry and of exit; -1 where it misses
};

/// A parallel projection of a grid: in index space all rays have one direction, and pixels are an affine
/// function of the place.
class ParallelView {
 public:
  /// \throws vol::Error on a perspective view, or where the camera or the box does
  ParallelView(const volume::GridGeometry& geometry, const camera::View& view, int width, int height);

  [[nodiscard]] int width() const { return camera_.image_width(); }
  [[nodiscard]] int height() const { return camera_.image_height(); }
  /// Index-space displacements of a world length along a ray, and of one pixel to the right and down.
  [[nodiscard]] const Vec3& direction() const { return direction_; }
  [[nodiscard]] const Vec3& right() const { return right_; }
  [[nodiscard]] const Vec3& down() const { return down_; }
  /// Column and row, pixel centres at whole numbers, of the ray through a point in index space.
  [[nodiscard]] std::array<double, 2> pixel(const Vec3& p_index) const {
    const Vec3 p = to_pixel_ * (p_index - first_);
    return {p[0], p[1]};
  }
  /// A ray that meets the box, as casters take it.
  struct Cast {
    camera::Ray ray;
    Chord chord;
  };
  [[nodiscard]] std::optional<Cast> cast(int x, int y) const;
  /// Middles are those that WaveletXray integrates from, bit for bit. Where a ray passes an edge of the box
  /// to 1e-9 of its chord, the face of the lower axis counts.
  void row(int y, PixelRow& row) const;
  /// Position of the face through which rays enter (0) or leave (1), on an axis.
  [[nodiscard]] double face(int which, int axis) const;

 private:
  volume::GridGeometry geometry_;
  RayBox box_;
  camera::Camera camera_;
  Vec3 direction_, right_, down_, first_;
  Mat3 to_pixel_;
};

}  // namespace vol::render
