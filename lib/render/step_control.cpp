#include "render/step_control.h"

#include <algorithm>
#include <cmath>

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

double light_share(const Shading& shading, double step, double spacing) {
  return spacing > 0 ? (shading.diffuse + shading.specular) * step * step / (2 * spacing) : 0;
}

int doublings_in_light(double e, int most) {
  if (!(e > 0)) return most;
  // 4^n e <= 1; as the packets have it, by e's exponent alone (a power of two counts as above itself).
  const int exponent = std::ilogb(std::min(e, 1e30));
  return std::clamp((-1 - exponent) >> 1, 0, most);
}

void require_adaptive_steps_can_be(const Scene& scene, bool index) {
  if (scene.model != Model::composite) {
    throw Error("step tolerance: composite is the model that has steps of adaptive length");
  }
  if (index) throw Error("step tolerance: an index chooses steps already");
}

}  // namespace vol::render
