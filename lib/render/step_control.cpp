#include "render/step_control.h"

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

void require_adaptive_steps_can_be(const Scene& scene, bool index) {
  if (scene.model != Model::composite) {
    throw Error("step tolerance: composite is the model that has steps of adaptive length");
  }
  if (index) throw Error("step tolerance: an index chooses steps already");
}

}  // namespace vol::render
