#include "render/parallel_view.h"

#include <cmath>
#include <limits>

#include "base/error.h"
#include "volume/grid_sampler.h"

namespace vol::render {

ParallelView::ParallelView(const volume::GridGeometry& geometry, const camera::View& view, int width,
                           int height)
    : geometry_(geometry),
      box_(volume::field_bounds(geometry)),
      camera_(view, volume::field_bounds(geometry).centre(), volume::field_bounds(geometry).longest_edge(),
              width, height) {
  if (view.projection != camera::Projection::orthographic) {
    throw Error(
        "footprints are those of a parallel projection; take --algorithm rays for a perspective view");
  }
  const Mat3 to_index = geometry.world_to_index_matrix();
  const camera::Ray first = camera_.ray(0.5, 0.5);
  direction_ = to_index * first.direction;
  // Over the whole picture, so that its last pixel is as exact as its first.
  right_ = to_index * (camera_.ray(width + 0.5, 0.5).origin - first.origin) / width;
  down_ = to_index * (camera_.ray(0.5, height + 0.5).origin - first.origin) / height;
  first_ = geometry.world_to_index(first.origin);
  Mat3 columns;
  columns << right_, down_, direction_;
  to_pixel_ = columns.inverse();
}

std::optional<ParallelView::Cast> ParallelView::cast(int x, int y) const {
  const camera::Ray ray = camera_.ray(x + 0.5, y + 0.5);
  const auto chord = box_.chord(ray, camera_.t_min());
  if (!chord) return std::nullopt;
  return Cast{ray, *chord};
}

double ParallelView::face(int which, int axis) const {
  const Box3 box = geometry_.index_box();
  return (direction_[axis] > 0) == (which == 1) ? box.max[axis] : box.min[axis];
}

void ParallelView::row(int y, PixelRow& row) const {
  const auto count = static_cast<std::size_t>(width());
  for (auto& axis : row.middle) axis.assign(count, 0.0);
  row.half.assign(count, -1.0);
  for (auto& face : row.face) face.assign(count, -1);
  for (std::size_t x = 0; x < count; ++x) {
    const auto met = cast(static_cast<int>(x), y);
    if (!met) continue;
    const double t = 0.5 * (met->chord.entry + met->chord.exit), half = 0.5 * met->chord.length();
    const Vec3 middle = geometry_.world_to_index(met->ray.origin + t * met->ray.direction);
    row.half[x] = half;
    for (std::size_t a = 0; a < 3; ++a) row.middle[a][x] = middle[static_cast<Eigen::Index>(a)];
    for (int which = 0; which < 2; ++which) {
      double nearest = std::numeric_limits<double>::infinity();
      for (int a = 0; a < 3; ++a) {
        if (direction_[a] == 0) continue;
        const double distance = std::abs((face(which, a) - middle[a]) / direction_[a]);
        if (distance < nearest - 1e-9 * half) {
          nearest = distance;
          row.face[static_cast<std::size_t>(which)][x] = static_cast<std::int8_t>(a);
        }
      }
    }
  }
}

}  // namespace vol::render
