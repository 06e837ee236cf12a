#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "base/rng.h"
#include "camera/camera.h"

namespace vol::camera {
namespace {

View view(double azimuth, double elevation) {
  View v;
  v.azimuth = azimuth;
  v.elevation = elevation;
  return v;
}

TEST(Camera, LooksFromPlusZAtZeroAngles) {
  const Camera camera(view(0, 0), Vec3(1, 2, 3), 10, 64, 32);
  EXPECT_TRUE(camera.direction().isApprox(Vec3(0, 0, -1)));
  EXPECT_TRUE(camera.right().isApprox(Vec3(1, 0, 0)));
  EXPECT_TRUE(camera.up().isApprox(Vec3(0, 1, 0)));
  EXPECT_TRUE(camera.ray(32, 16).origin.isApprox(Vec3(1, 2, 3)));
}

TEST(Camera, PositiveAzimuthMovesTowardPlusXAndElevationUp) {
  EXPECT_TRUE(Camera(view(90, 0), Vec3::Zero(), 1, 8, 8).direction().isApprox(Vec3(-1, 0, 0)));
  EXPECT_LT(Camera(view(0, 40), Vec3::Zero(), 1, 8, 8).direction().y(), 0);
}

TEST(Camera, FrameIsOrthonormalAndContinuousUpToThePoles) {
  Rng rng(2);
  for (int trial = 0; trial < 200; ++trial) {
    const double a = rng.uniform(-360, 360), e = trial % 3 == 0 ? (trial % 2 ? 90 : -90) : rng.uniform(-90, 90);
    const Camera c(view(a, e), Vec3::Zero(), 1, 8, 8);
    Mat3 frame;
    frame << c.right(), c.up(), -c.direction();
    EXPECT_TRUE((frame.transpose() * frame).isIdentity(1e-12));
    EXPECT_NEAR(frame.determinant(), 1, 1e-12);  // not mirrored
    const double nearby = e > 0 ? e - 1e-7 : e + 1e-7;
    EXPECT_LT((Camera(view(a, nearby), Vec3::Zero(), 1, 8, 8).right() - c.right()).norm(), 1e-6);
  }
}

TEST(Camera, RowZeroIsTheTopAndPixelsAreSquare) {
  View v = view(0, 0);
  v.width = 8;
  const Camera camera(v, Vec3::Zero(), 1, 16, 4);
  EXPECT_TRUE(camera.ray(0.5, 0.5).origin.isApprox(Vec3(-3.75, 0.75, 0)));
  EXPECT_TRUE(camera.ray(15.5, 3.5).origin.isApprox(Vec3(3.75, -0.75, 0)));
}

TEST(Camera, PerspectiveShowsTheFieldOfViewAndTheDefaultWidth) {
  View v = view(25, -35);
  v.projection = Projection::perspective;
  v.fov = 50;
  const Camera camera(v, Vec3(4, 5, 6), 3, 20, 10);
  const Vec3 top = camera.ray(10, 0).direction, bottom = camera.ray(10, 10).direction;
  EXPECT_NEAR(std::acos(top.dot(bottom)) * 180 / M_PI, 50, 1e-9);
  EXPECT_NEAR(camera.width(), 1.6 * 3, 1e-12);
  const Ray centre = camera.ray(10, 5);
  EXPECT_NEAR((Vec3(4, 5, 6) - centre.origin).cross(centre.direction).norm(), 0, 1e-12);
}

TEST(Camera, RefusesWhatIsNotAView) {
  EXPECT_THROW(Camera(view(0, 91), Vec3::Zero(), 1, 8, 8), Error);
  View v = view(0, 0);
  v.width = 0;
  EXPECT_THROW(Camera(v, Vec3::Zero(), 1, 8, 8), Error);
  v = view(0, 0);
  v.projection = Projection::perspective;
  v.fov = 180;
  EXPECT_THROW(Camera(v, Vec3::Zero(), 1, 8, 8), Error);
}

}  // namespace
}  // namespace vol::camera
