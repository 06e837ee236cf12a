#include "render/step_control.h"

#include <algorithm>

#include "base/error.h"
#include "render/packet_rays.h"
#include "render/ray_box.h"

namespace vol::render {

int most_halvings(const volume::FieldBounds& bounds, double step) {
  const double steps = longest_diagonal(bounds) / step;
  int halvings = kHalvings;
  while (halvings > 0 && !(steps * (1 << halvings) < kMostSegments - 1)) --halvings;
  return halvings;
}

double smallest_cell(const volume::GridGeometry& geometry, volume::Reconstruction reconstruction) {
  if (reconstruction != volume::Reconstruction::trilinear) return 0;
  double least = 0;
  for (int a = 0; a < 3; ++a) {
    if (geometry.dims[a] > 1) least = least > 0 ? std::min(least, geometry.spacing[a]) : geometry.spacing[a];
  }
  return least;
}

double shading_share(const Shading& shading, double h, double cell) {
  return cell > 0 ? (shading.diffuse + shading.specular) * h * (h / cell) / 2 : 0;
}

int doublings_in_shading(double g, int most) {
  int n = 0;
  for (; n < most && 4 * g <= 1; g *= 4) ++n;
  return n;
}

void require_adaptive_steps_can_be(const Scene& scene, bool index) {
  if (scene.model != Model::composite) {
    throw Error("step tolerance: composite is the model that has steps of adaptive length");
  }
  if (index) throw Error("step tolerance: an index chooses steps already");
}

}  // namespace vol::render
