#include "render/node_walk.h"

#include <cmath>
#include <sstream>

#include "base/error.h"

namespace vol::render {

NodeWalk::NodeWalk(const camera::Ray& ray, const Chord& chord, double step, const RayBox& box,
                   const index::IndexVolume* index)
    : ray_(ray), chord_(chord), step_(step), box_(box), index_(index) {
  constexpr double kMaxNodes = 1e9;
  const double segments = std::ceil(chord.length() / step - 1e-9);
  if (!(segments < kMaxNodes)) {
    std::ostringstream message;
    message << "a ray would have more than 1e9 nodes, " << step << " apart; take a longer step";
    throw Error(message.str());
  }
  last_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(segments));
}

int NodeWalk::entry_at(const Vec3& u) const {
  std::int64_t e[3];
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = index_->volume_dims()[a];
    const double cell = u[a] * static_cast<double>(n - 1);
    e[a] = (!(cell > 0) ? 0 : std::min(static_cast<std::int64_t>(cell), n - 1)) / index_->reduction();
  }
  return index_->entry(e[0], e[1], e[2]);
}

}  // namespace vol::render
