#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>

#include "base/error.h"
#include "render/grid_field.h"
#include "render/picture.h"
#include "render/quadrature.h"
#include "render/raycast.h"
#include "render/step_control.h"
#include "render/visibility.h"
#include "volume/grid_sampler.h"

namespace vol::render {
namespace {

/// The ray's nodes that are visited, in order: every one, or those an index leaves.
class NodeWalk {
 public:
  NodeWalk(const camera::Ray& ray, const Chord& chord, double step, const RayBox& box,
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

  [[nodiscard]] std::int64_t last() const { return last_; }
  [[nodiscard]] double t(std::int64_t node) const {
    return node == last_ ? chord_.exit : chord_.entry + static_cast<double>(node) * step_;
  }
  [[nodiscard]] Vec3 position(std::int64_t node) const { return ray_.origin + t(node) * ray_.direction; }
  [[nodiscard]] Vec3 coordinates(std::int64_t node) const { return box_.coordinates(position(node)); }
  [[nodiscard]] std::int64_t after(std::int64_t node) const {
    if (!index_) return node + 1;
    return std::min(last_, node + (std::int64_t{1} << entry_at(coordinates(node))));
  }

 private:
  [[nodiscard]] int entry_at(const Vec3& u) const {
    std::int64_t e[3];
    for (int a = 0; a < 3; ++a) {
      const std::int64_t n = index_->volume_dims()[a];
      const double cell = u[a] * static_cast<double>(n - 1);
      e[a] = (!(cell > 0) ? 0 : std::min(static_cast<std::int64_t>(cell), n - 1)) / index_->reduction();
    }
    return index_->entry(e[0], e[1], e[2]);
  }

  const camera::Ray& ray_;
  const Chord& chord_;
  double step_;
  const RayBox& box_;
  const index::IndexVolume* index_;
  std::int64_t last_ = 1;
};

/// What a ray needs besides itself.
struct Context {
  FieldView field;
  RenderOptions options;
  RayBox box;
  const index::IndexVolume* index = nullptr;
  const LabelledMedium* labels = nullptr;
  std::optional<GridField> grid = {};                ///< keeps `field` alive
  Dims dims{1, 1, 1};                                ///< of the grid
  std::optional<index::Macrocells> macrocells = {};  ///< where empty space is skipped
  std::optional<Visibility> visibility = {};
  std::optional<Optics> optics = {};
  std::optional<BlinnPhong> shading = {};
  std::int64_t longest_hop = 1;  ///< of steps of adaptive length, in nodes of the walk
};

class CompositeRay {
 public:
  CompositeRay(const Context& context, const NodeWalk& walk, const Vec3& direction, RenderCounts& counts)
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
    std::int64_t hop = context_.longest_hop;
    for (bool arrived = true; !(transmittance <= context_.options.termination);) {
      if (arrived && left.number < last && left.node.opacity == 0) {
        const std::int64_t node = before_what_is_visible(left.number, last);
        if (node > left.number) hop = context_.longest_hop;
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
        if (grows) hop = std::min(2 * hop, context_.longest_hop);
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

  /// h/2 max(|s0 - 2 s1 + s2|, |s0 c0 - 2 s1 c1 + s2 c2|), s extinctions; opaque ones count as finite.
  [[nodiscard]] double trapezoids_differ(const Node& left, const Node& middle, const Node& right,
                                         double h) const {
    constexpr double kMost = 1e30;
    const auto extinction = [&](const Node& n) { return std::min(-std::log1p(-n.opacity), kMost); };
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

  const Context& context_;
  const NodeWalk& walk_;
  const Vec3& direction_;
  RenderCounts& counts_;
};

/// Integral of f: left node, or both (trapezoid and preintegrated, which for f itself are the same).
Pixel xray(const Context& context, const NodeWalk& walk, RenderCounts& counts) {
  const bool both = context.options.quadrature != Quadrature::rectangle;
  double sum = 0;
  double left = context.field.value(walk.position(0));
  ++counts.samples;
  for (std::int64_t node = 0; node < walk.last();) {
    const std::int64_t next = walk.after(node);
    const double h = walk.t(next) - walk.t(node);
    double right = 0;
    if (both || next < walk.last()) {
      right = context.field.value(walk.position(next));
      ++counts.samples;
    }
    sum += h * (both ? 0.5 * left + 0.5 * right : left);
    left = right;
    node = next;
  }
  return {Vec3::Constant(sum), 1, std::numeric_limits<double>::infinity(), 0};
}

/// Largest value of the visited nodes; the first where several are equal.
Pixel mip(const Context& context, const NodeWalk& walk, RenderCounts& counts) {
  double most = -std::numeric_limits<double>::infinity();
  double depth = 0;
  for (std::int64_t node = 0;; node = walk.after(node)) {
    const double value = context.field.value(walk.position(node));
    ++counts.samples;
    if (value > most) {
      most = value;
      depth = walk.t(node);
    }
    if (node == walk.last()) break;
  }
  return {Vec3::Constant(most), 1, depth, 0};
}

/// Adds what options and scene say, and refuses what no steps can do.
std::shared_ptr<const Context> complete(Context context, const Scene& scene, double smallest_spacing) {
  require_valid(context.options);
  if (context.options.quadrature >= Quadrature::split) {
    throw Error("quadratures split and reference have no steps to cast by; call raycast_reference");
  }
  if (context.options.step_tolerance > 0) {
    require_adaptive_steps_can_be(scene, context.index != nullptr);
    context.longest_hop = std::int64_t{1} << most_halvings(context.field.bounds, context.options.step);
    context.options.step /= static_cast<double>(context.longest_hop);  // the walk's nodes
  }
  if (scene.model == Model::composite) {
    context.optics.emplace(scene.transfer, resolved_reference_length(scene, smallest_spacing));
    if (scene.shading) context.shading.emplace(*scene.shading);
  }
  return std::make_shared<const Context>(std::move(context));
}

RayCaster caster(const std::shared_ptr<const Context>& shared, const Scene& scene) {
  return [shared, model = scene.model](const camera::Ray& ray, const Chord& chord, RenderCounts& counts) {
    const NodeWalk walk(ray, chord, shared->options.step, shared->box, shared->index);
    switch (model) {
      case Model::xray:
        return xray(*shared, walk, counts);
      case Model::mip:
        return mip(*shared, walk, counts);
      default:
        Beam beam;
        CompositeRay(*shared, walk, ray.direction, counts).cast(beam);
        return beam.pixel;
    }
  };
}

MediumCaster medium(const std::shared_ptr<const Context>& shared, const Scene& scene) {
  if (scene.model != Model::composite) throw Error("only the model composite has a medium between surfaces");
  return [shared](const camera::Ray& ray, const Chord& part, double, Beam& beam, RenderCounts& counts) {
    const NodeWalk walk(ray, part, shared->options.step, shared->box, shared->index);
    CompositeRay(*shared, walk, ray.direction, counts).cast(beam);
  };
}

RenderResult drawn(const volume::FieldBounds& bounds, const Scene& scene, const RenderOptions& options,
                   const RayCaster& cast) {
  RenderResult result = draw(bounds, scene, options, cast);
  result.error_estimate = std::numeric_limits<double>::quiet_NaN();
  return result;
}

std::shared_ptr<const Context> context_of(const FieldView& field, const Scene& scene,
                                          const RenderOptions& options, const index::IndexVolume* index) {
  return complete({.field = field, .options = options, .box = RayBox(field.bounds), .index = index}, scene,
                  0);
}

/// Labels are known at nodes alone: what lies between two of them is not the value's way from one to the
/// other.
void require_labels_can_be_drawn(const Scene& scene, const RenderOptions& options,
                                 const index::IndexVolume* index) {
  if (scene.model != Model::composite) throw Error("labels are drawn by the model composite alone");
  if (options.quadrature != Quadrature::rectangle && options.quadrature != Quadrature::trapezoid) {
    throw Error("labels are drawn by the quadratures rectangle and trapezoid alone");
  }
  if (index) throw Error("an index of the field says nothing of its labels");
}

std::shared_ptr<const Context> context_of(const volume::Volume& volume, const Scene& scene,
                                          const RenderOptions& options, const index::IndexVolume* index,
                                          const LabelledMedium* labels) {
  (void)volume::value_range(volume);  // refuses NaN and infinity
  if (labels) require_labels_can_be_drawn(scene, options, index);
  const volume::GridGeometry& geometry = volume.geometry();
  if (index && index->volume_dims() != geometry.dims) {
    throw Error("index volume was built for other dims than the volume's");
  }
  const GridField field(volume, options.reconstruction);
  Context context{.field = field.view(),
                  .options = options,
                  .box = RayBox(field.view().bounds),
                  .index = index,
                  .labels = labels,
                  .grid = field};
  if (options.skip_empty && labels) {
    context.visibility.emplace(labels->visibility());
    context.dims = geometry.dims;
  } else if (options.skip_empty && scene.model == Model::composite) {
    context.macrocells.emplace(index::macrocells(volume, options.reconstruction));
    context.visibility.emplace(visibility(*context.macrocells, scene.transfer));
    context.dims = geometry.dims;
  }
  return complete(std::move(context), scene, geometry.spacing.minCoeff());
}

}  // namespace

RayCaster plain_caster(const FieldView& field, const Scene& scene, const RenderOptions& options,
                       const index::IndexVolume* index) {
  return caster(context_of(field, scene, options, index), scene);
}

RayCaster plain_caster(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                       const index::IndexVolume* index, const LabelledMedium* labels) {
  return caster(context_of(volume, scene, options, index, labels), scene);
}

MediumCaster plain_medium(const FieldView& field, const Scene& scene, const RenderOptions& options,
                          const index::IndexVolume* index) {
  return medium(context_of(field, scene, options, index), scene);
}

MediumCaster plain_medium(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                          const index::IndexVolume* index, const LabelledMedium* labels) {
  return medium(context_of(volume, scene, options, index, labels), scene);
}

RenderResult raycast_plain(const FieldView& field, const Scene& scene, const RenderOptions& options,
                           const index::IndexVolume* index) {
  return drawn(field.bounds, scene, options, plain_caster(field, scene, options, index));
}

RenderResult raycast_plain(const volume::Volume& volume, const Scene& scene, const RenderOptions& options,
                           const index::IndexVolume* index, const LabelledMedium* labels) {
  return drawn(volume::field_bounds(volume.geometry()), scene, options,
               plain_caster(volume, scene, options, index, labels));
}

}  // namespace vol::render
