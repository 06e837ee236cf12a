#pragma once
#include "render/options.h"
#include "volume/field_sampler.h"
#include "volume/grid_geometry.h"

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
/// Of shading three nodes do not foresee the error: normals of a trilinear field jump from cell to cell, and
/// hardly differ in between. In shaded scenes a pair's steps are therefore also the longest of these whose
///   g = T s h (h/v) (k_d + k_s) / 2
/// is at most the tolerance, T and s those at the pair's first node, v the smallest spacing (the shortest
/// step passes whatever g is): of what a step adds to the pixel, a share that grows with the cells it leaves
/// out. Colours count as 1; the 1/2 is measured (decisions.md). It needs no pair tried in vain. Volumes of
/// trilinear cells only: of other fields it is not known where gradients jump.
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

/// v above: the smallest spacing of an axis of several samples; 0 for other reconstructions than trilinear.
[[nodiscard]] double smallest_cell(const volume::GridGeometry& geometry,
                                   volume::Reconstruction reconstruction);

/// g / (T s) for steps of length h; 0 where `cell`, v, is 0.
[[nodiscard]] double shading_share(const Shading& shading, double h, double cell);

/// How often the shortest step may be doubled: the largest n <= most with 4^n g <= 1, or 0.
/// \param g  of the shortest step, in units of the tolerance
[[nodiscard]] int doublings_in_shading(double g, int most);

/// \throws vol::Error where steps are not this rule's to choose: other models, an index
void require_adaptive_steps_can_be(const Scene& scene, bool index);

}  // namespace vol::render
