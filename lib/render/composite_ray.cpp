#include "render/composite_ray.h"

#include <algorithm>
#include <cmath>

#include "render/step_control.h"

namespace vol::render {
namespace {

class CompositeRay {
 public:
  CompositeRay(const RayContext& context, const NodeWalk& walk, const Vec3& direction, RenderCounts& counts)
      : context_(context), walk_(walk), direction_(direction), counts_(counts) {}

  void cast(Beam& beam) {
    if (context_.options.step_tolerance > 0) return cast_by_step_control(beam);
    const double& transmittance = beam.transmittance;
    Visit left = visit(0);
    while (left.number < walk_.last() && !(transmittance <= context_.options.termination)) {
      const std::int64_t next = after_empty_space(left);
      Visit right = visit(next > left.number ? next : walk_.after(left.number));
      const bool visible = prepare(left, right);
      const double t0 = walk_.t(left.number);
      const double h = walk_.t(right.number) - t0;
      pass(visible ? rule(left.node, right.node, h) : Segment{}, t0, h, beam);
      if (!left.sampled) ++counts_.skipped;
      left = right;
    }
    if (left.number < walk_.last()) {
      ++counts_.terminated;
    } else if (kind() != Quadrature::rectangle && !left.sampled) {
      ++counts_.skipped;
    }
  }

 private:
  struct Visit {
    std::int64_t number;
    bool invisible = false;  ///< by its macrocell
    Node node{};             ///< opacity 0 until sampled
    bool sampled = false;
    bool lit = false;
  };

  /// A segment of length h from t0 on.
  static void pass(const Segment& segment, double t0, double h, Beam& beam) {
    double& transmittance = beam.transmittance;
    const double behind = transmittance * segment.transmittance;
    if (transmittance > 0.5 && behind <= 0.5) {
      const double fraction = std::log(2 * transmittance) / segment.optical_depth;
      beam.pixel.depth = t0 + h * std::clamp(fraction, 0.0, 1.0);
    }
    beam.pixel.colour += transmittance * segment.emission;
    beam.pixel.alpha += transmittance * segment.alpha;
    transmittance = behind;
  }

  /// Steps of adaptive length (step_control.h); the walk's nodes are those of the shortest step.
  void cast_by_step_control(Beam& beam) {
    const double& transmittance = beam.transmittance;
    const std::int64_t last = walk_.last() - 1;  // of the lattice; behind it is the ray's short end
    Visit left = visit(0);
    look(left);
    if (!left.sampled) ++counts_.skipped;
    std::int64_t hop = most_hop(left, transmittance);
    for (bool arrived = true; !(transmittance <= context_.options.termination);) {
      if (arrived && left.number < last && left.node.opacity == 0) {
        const std::int64_t node = before_what_is_visible(left.number, last);
        if (node > left.number) hop = std::int64_t{1} << context_.halvings;
        counts_.skipped += node - left.number;
        left.number = node;
      }
      if (left.number + 2 > last) break;
      while (left.number + 2 * hop > last) hop /= 2;
      Visit middle{left.number + hop}, right{left.number + 2 * hop};
      look(middle);
      look(right);
      const double t0 = walk_.t(left.number), t1 = walk_.t(middle.number), t2 = walk_.t(right.number);
      const double difference =
          transmittance * trapezoids_differ(left.node, middle.node, right.node, t1 - t0);
      arrived = difference <= context_.options.step_tolerance || hop == 1;
      if (arrived) {
        pass(trapezoid(left.node, middle.node, t1 - t0, *context_.optics), t0, t1 - t0, beam);
        pass(trapezoid(middle.node, right.node, t2 - t1, *context_.optics), t1, t2 - t1, beam);
        left = right;
        const bool grows = difference <= kGrowBelow * context_.options.step_tolerance;
        hop = std::min(grows ? 2 * hop : hop, most_hop(left, transmittance));
      } else {
        hop /= 2;
      }
    }
    if (transmittance <= context_.options.termination) {
      ++counts_.terminated;
      return;
    }
    Visit end = visit(walk_.last());
    if (end.invisible && left.node.opacity == 0) {
      ++counts_.skipped;
      return;
    }
    end.invisible = false;
    look(end);
    const double t0 = walk_.t(left.number);
    const double h = walk_.t(end.number) - t0;
    pass(trapezoid(left.node, end.node, h, *context_.optics), t0, h, beam);
  }

  void look(Visit& visit) {
    if (!visit.invisible) sample(visit);
    if (visit.node.opacity > 0) light(visit);
  }

  /// The last node before the first that may be visible, or `last` where none is; `node` where it may be
  /// itself.
  [[nodiscard]] std::int64_t before_what_is_visible(std::int64_t node, std::int64_t last) const {
    if (!visit(node).invisible) return node;
    while (node < last && visit(node).invisible) ++node;
    return visit(node).invisible ? node : node - 1;
  }

  /// The longest steps from a node on that shading allows, in nodes.
  [[nodiscard]] std::int64_t most_hop(const Visit& visit, double transmittance) const {
    const double g = transmittance * context_.shading_share * extinction(visit.node) /
                     (context_.optics->reference_length() * context_.options.step_tolerance);
    return std::int64_t{1} << doublings_in_shading(g, context_.halvings);
  }

  /// A reference length; an opaque node's counts as finite.
  [[nodiscard]] static double extinction(const Node& node) {
    constexpr double kMost = 1e30;
    return std::min(-std::log1p(-node.opacity), kMost);
  }

  /// h/2 max(|s0 - 2 s1 + s2|, |s0 c0 - 2 s1 c1 + s2 c2|), s extinctions.
  [[nodiscard]] double trapezoids_differ(const Node& left, const Node& middle, const Node& right,
                                         double h) const {
    const auto emission = [&](const Node& n) -> Vec3 { return extinction(n) * n.lit(n.colour); };
    const double absorbed = extinction(left) - 2 * extinction(middle) + extinction(right);
    const Vec3 emitted = emission(left) - 2 * emission(middle) + emission(right);
    return 0.5 * h / context_.optics->reference_length() *
           std::max(std::abs(absorbed), emitted.cwiseAbs().maxCoeff());
  }

  [[nodiscard]] Quadrature kind() const { return context_.options.quadrature; }
  [[nodiscard]] const transfer::TransferFunction& transfer() const { return context_.optics->transfer(); }

  [[nodiscard]] std::size_t macrocell(std::int64_t number) const {
    return context_.visibility->offset(walk_.coordinates(number), context_.dims);
  }
  [[nodiscard]] Visit visit(std::int64_t number) const {
    return {number, context_.visibility && context_.visibility->distance[macrocell(number)] > 0};
  }
  /// Whether two macrocells, and all values between theirs, are invisible.
  [[nodiscard]] bool invisible_between(std::int64_t node, std::int64_t next) const {
    const index::Macrocells& cells = *context_.macrocells;
    const volume::Range a = widened(cells.ranges[macrocell(node)], cells.all);
    const volume::Range b = widened(cells.ranges[macrocell(next)], cells.all);
    return transfer().max_opacity(std::min(a.min, b.min), std::max(a.max, b.max)) == 0;
  }

  /// With an index: a ray in an invisible macrocell follows no entries; it goes on from the last node before
  /// the first that may be visible, which becomes `left`. Returns that visible node, or left.number if it
  /// need not.
  std::int64_t after_empty_space(Visit& left) {
    if (!context_.index || !left.invisible) return left.number;
    std::int64_t node = left.number;
    while (node < walk_.last() && (kind() == Quadrature::preintegrated ? invisible_between(node, node + 1)
                                                                       : visit(node + 1).invisible)) {
      ++node;
    }
    node = std::min(node, walk_.last() - 1);
    if (node > left.number) {
      counts_.skipped += node - left.number;
      left = visit(node);
    }
    return node + 1;
  }

  /// Samples what the segment's rule needs. What is surely transparent is left as it is, with opacity 0; for
  /// preintegrated that takes all values between the two nodes. False: nothing there.
  bool prepare(Visit& left, Visit& right) {
    if (kind() == Quadrature::preintegrated) {
      if (left.invisible && right.invisible && invisible_between(left.number, right.number)) return false;
      sample(left);
      sample(right);
      if (transfer().max_opacity(std::min(left.node.value, right.node.value),
                                 std::max(left.node.value, right.node.value)) > 0) {
        light(left);
        light(right);
      }
      return true;
    }
    for (Visit* end : {&left, &right}) {
      if (end == &right && kind() == Quadrature::rectangle) break;
      if (!end->invisible) sample(*end);
      if (end->node.opacity > 0) light(*end);
    }
    return true;
  }

  void sample(Visit& visit) {
    if (visit.sampled) return;
    visit.sampled = true;
    ++counts_.samples;
    if (context_.labels) {
      visit.node = context_.labels->node(walk_.position(visit.number), context_.field, transfer());
      return;
    }
    visit.node.value = context_.field.value(walk_.position(visit.number));
    visit.node.opacity = transfer().opacity(visit.node.value);
    visit.node.colour = transfer().colour(visit.node.value);
  }
  void light(Visit& visit) {
    if (visit.lit || !context_.shading) return;
    visit.lit = true;
    ++counts_.gradients;
    visit.node.lit = (*context_.shading)(context_.field.gradient(walk_.position(visit.number)), direction_);
  }
  [[nodiscard]] Segment rule(const Node& left, const Node& right, double h) const {
    switch (context_.options.quadrature) {
      case Quadrature::rectangle:
        return rectangle(left, h, *context_.optics);
      case Quadrature::preintegrated:
        return preintegrated(left, right, h, *context_.optics);
      default:
        return trapezoid(left, right, h, *context_.optics);
    }
  }

  const RayContext& context_;
  const NodeWalk& walk_;
  const Vec3& direction_;
  RenderCounts& counts_;
};

}  // namespace

void pass_composite(const RayContext& context, const NodeWalk& walk, const Vec3& direction, Beam& beam,
                    RenderCounts& counts) {
  CompositeRay(context, walk, direction, counts).cast(beam);
}

}  // namespace vol::render
