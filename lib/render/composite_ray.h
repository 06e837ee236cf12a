#pragma once
#include <cstdint>
#include <optional>

#include "index/macrocells.h"
#include "render/grid_field.h"
#include "render/node_walk.h"
#include "render/picture.h"
#include "render/quadrature.h"
#include "render/visibility.h"

namespace vol::render {

/// What a ray of the plain caster needs besides itself.
struct RayContext {
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
  // Steps of adaptive length (step_control.h):
  double cell = 0;           ///< smallest_cell()
  int halvings = 0;          ///< the longest step is 2 to this nodes of the walk
  double shading_share = 0;  ///< of the walk's step
};

/// Emission and absorption along a ray, or the part of one that a walk covers, in double precision: what the
/// packets are held against. By the rule of `context.options.quadrature` from node to node (the walk's, which
/// leave out what an index does and what macrocells make invisible), or by steps of adaptive length
/// (step_control.h).
///
/// \param beam  what the ray has gathered so far; where its transmittance falls to `termination` it ends
void pass_composite(const RayContext& context, const NodeWalk& walk, const Vec3& direction, Beam& beam,
                    RenderCounts& counts);

}  // namespace vol::render
