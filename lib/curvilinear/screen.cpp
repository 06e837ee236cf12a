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

Solid Screen::view(const Solid& world) const {
  Solid seen = world;
  for (Point4& p : seen.b) p.head<3>() = view(Vec3(p.head<3>()));
  return seen;
}

}  // namespace vol::curvilinear
