#pragma once
#include "render/options.h"
#include "volume/field_sampler.h"

namespace vol::render {

/// Steps of adaptive length (RenderOptions::step_tolerance): composite, by trapezoid.
///
/// A ray takes two steps of length h at once. With extinctions s and colours c at their three nodes and the
/// transmittance T that arrives at the first, one trapezoid over both differs in the pixel from two by about
///   e = T h/2 max(|s0 - 2 s1 + s2|, |s0 c0 - 2 s1 c1 + s2 c2| by channel),
/// three times the error of the two where the field is smooth (step doubling: Hairer, Norsett & Wanner 1993,
/// section II.4). If e is above the tolerance, the pair is not passed but tried again with half the steps,
/// down to 2^-most_halvings() of the step asked for; if e is at most an eighth of it, the next pair's steps
/// are twice as long: e grows with h^3 where the field is smooth. T weights what lies deep in the medium by
/// what is seen of it.
///
/// Where light falls, three nodes do not foresee e: normals of a trilinear field jump from cell to cell, and
/// between nodes in the same cells hardly differ. There steps from a node of extinction s on are also not
/// longer, by powers of two, than
///   e = T s h (h/v) (k_d + k_s) / 2
/// allows, v the smallest spacing: of what a step adds to the pixel, a share that grows with the cells it
/// leaves out. That needs no pair tried in vain.
///
/// Nodes are those of the lattice of the shortest step, from the ray's entry on. Near the ray's end steps are
/// short enough for a pair; what is left in the end, at most two of the shortest, is one segment. In empty
/// space a ray at a node of extinction 0 goes on from the last node before the first that may be visible, and
/// with the longest step if that is further on.
inline constexpr int kHalvings = 4;
inline constexpr float kGrowBelow = 0.125F;

/// How often a step is halved at most: kHalvings, or fewer so that no ray through the box has more nodes than
/// packets hold (packet_rays.h), where not halving brings that about.
[[nodiscard]] int most_halvings(const volume::FieldBounds& bounds, double step);

/// (k_d + k_s) h^2 / (2 v) for steps of length h: what they may err by per extinction, in light.
/// \param spacing  the field's smallest, v; 0 where its gradients do not jump: nothing
[[nodiscard]] double light_share(const Shading& shading, double step, double spacing);

/// How often the shortest step may be doubled at a node: log4(tolerance / e), rounded down, at most `most`.
/// \param e  of the shortest step, in units of the tolerance
[[nodiscard]] int doublings_in_light(double e, int most);

/// \throws vol::Error where steps are not this rule's to choose: other models, an index
void require_adaptive_steps_can_be(const Scene& scene, bool index);

}  // namespace vol::render
