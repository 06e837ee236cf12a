#include "curvilinear/screen.h"

namespace vol::curvilinear {

Screen::Screen(const camera::Camera& camera)
    : perspective_(camera.projection() == camera::Projection::perspective),
      eye_(camera.eye()),
      offset_(Vec3::Zero()),
      middle_(0.5 * camera.image_width(), 0.5 * camera.image_height()) {
  turn_ << camera.right().transpose(), -camera.up().transpose(), camera.direction().transpose();
  const double pixels = camera.image_width() / camera.width();  // a world unit, in the target's plane
  if (perspective_) {
    focal_ = pixels * camera.distance();
  } else {
    turn_ *= pixels;
    offset_.head<2>() = middle_;
    world_length_ = 1 / pixels;
  }
}

int Screen::runs_away(const Vec3& at, const Eigen::Matrix<double, 4, 3>& d, int axis) const {
  const double area =
      d.col((axis + 1) % 3).head<3>().cross(d.col((axis + 2) % 3).head<3>()).dot(direction(at));
  const double forward = d.topRows<3>().determinant() < 0 ? -area : area;
  return forward > 0 ? 1 : forward < 0 ? -1 : 0;
}

Block Screen::view(const Block& world) const {
  Block seen{world.dims, std::vector<Vec3>(world.points.size()), {}, world.hidden};
  for (std::size_t n = 0; n < world.points.size(); ++n) seen.points[n] = view(world.points[n]);
  return seen;
}

}  // namespace vol::curvilinear
