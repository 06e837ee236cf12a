#include "render/expansion_line.h"

#include <cmath>

namespace vol::render {

void ExpansionLine::visit(const camera::Ray& ray, const Chord& chord, const PieceSink& sink) {
  const auto& geometry = terms_.expansion().geometry();
  world_to_index_ = geometry.world_to_index_matrix();
  // From the chord's middle on, so that far eyes cost no digits.
  middle_ = 0.5 * (chord.entry + chord.exit);
  const double half = 0.5 * chord.length();
  line_.set(geometry.world_to_index(ray.origin + middle_ * ray.direction), world_to_index_ * ray.direction,
            -half, half);
  met_ += line_.size();
  list_.clear();
  for (std::uint32_t n = 0; n < line_.size(); ++n) list_.push_back(n);
  (void)part(-half, half, 0, list_.size(), sink);
}

bool ExpansionLine::part(double a, double b, std::size_t from, std::size_t to, const PieceSink& sink) {
  if (from == to) return sink({middle_ + a, middle_ + b, {}});
  if (const auto knot = line_.middle_knot(a, b, list_, from, to); knot && *knot > a && *knot < b) {
    for (const bool first : {true, false}) {
      const double low = first ? a : *knot, high = first ? *knot : b;
      const std::size_t top = list_.size();
      line_.narrow(list_, from, to, low, high);
      const bool go_on = part(low, high, top, list_.size(), sink);
      list_.resize(top);
      if (!go_on) return false;
    }
    return true;
  }
  ++pieces_;
  from_ = from;
  to_ = to;
  return sink({middle_ + a, middle_ + b, bernstein_of_powers(line_.polynomial(a, b, list_, from, to))});
}

Vec3 ExpansionLine::gradient(double t) {
  Vec3 size;
  Vec3 gradient = line_.gradient(t - middle_, list_, from_, to_, &size);
  for (int a = 0; a < 3; ++a) {
    if (std::abs(gradient[a]) <= 1e-13 * size[a]) gradient[a] = 0;
  }
  return world_to_index_.transpose() * gradient;
}

}  // namespace vol::render
