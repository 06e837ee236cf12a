#include "render/labelled_medium.h"

#include <algorithm>
#include <string>

#include "base/error.h"

namespace vol::render {
namespace {

std::string text(const Dims& d) {
  return std::to_string(d[0]) + "x" + std::to_string(d[1]) + "x" + std::to_string(d[2]);
}

}  // namespace

void require_dims_of(const volume::GridGeometry& labels, const volume::GridGeometry& volume) {
  if (labels.dims == volume.dims) return;
  throw Error("the labels are " + text(labels.dims) + " voxels, the volume is " + text(volume.dims));
}

LabelledMedium::LabelledMedium(volume::Grid<std::uint8_t> labels, const volume::GridGeometry& geometry,
                               LabelStyle style)
    : labels_(std::move(labels)),
      world_to_index_(geometry.world_to_index_matrix()),
      style_(std::move(style)) {
  require_dims_of(labels_.geometry, geometry);
  labels_.geometry = geometry;
  for (std::size_t l = 0; l < style_.looks.size() && l < looks_.size(); ++l) {
    const LabelLook& look = style_.looks[l];
    if (!(look.opacity >= 0 && look.opacity <= 1) || !look.colour.allFinite() || look.colour.minCoeff() < 0) {
      throw Error("label " + std::to_string(l) +
                  ": an opacity from 0 to 1 and finite colours of at least 0 are expected");
    }
    looks_[l] = look;
  }
}

LabelledMedium::Mixed LabelledMedium::mixed(const Vec3& p_index) const {
  const Dims& n = labels_.geometry.dims;
  std::int64_t low[3], high[3];
  double share[3];  // of the upper sample
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const double x = std::clamp(p_index[a], 0.0, static_cast<double>(n[axis] - 1));
    low[a] = static_cast<std::int64_t>(x);
    high[a] = std::min(low[a] + 1, n[axis] - 1);
    share[a] = x - static_cast<double>(low[a]);
  }
  if (style_.membership == Membership::nearest) {
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) at[a] = share[a] < 0.5 ? low[a] : high[a];
    const LabelLook& look = looks_[labels_(at[0], at[1], at[2])];
    return {look.opacity, look.colour};
  }
  // Where all eight have one opacity it is not summed: rounding would take from an opacity of 1.
  std::array<std::uint8_t, 8> corner;
  for (std::size_t c = 0; c < 8; ++c) {
    corner[c] = labels_((c & 1) != 0 ? high[0] : low[0], (c & 2) != 0 ? high[1] : low[1],
                        (c & 4) != 0 ? high[2] : low[2]);
  }
  if (std::all_of(corner.begin(), corner.end(), [&](auto l) { return l == corner[0]; })) {
    return {looks_[corner[0]].opacity, looks_[corner[0]].colour};
  }
  const double first = looks_[corner[0]].opacity;
  const bool one_opacity =
      std::all_of(corner.begin(), corner.end(), [&](auto l) { return looks_[l].opacity == first; });
  Mixed sum;
  for (std::size_t c = 0; c < 8; ++c) {
    double w = 1;
    for (std::size_t a = 0; a < 3; ++a) w *= (c >> a & 1) != 0 ? share[a] : 1 - share[a];
    const double opacity = w * looks_[corner[c]].opacity;
    sum.opacity += opacity;
    sum.colour += opacity * looks_[corner[c]].colour;
  }
  if (sum.opacity > 0) sum.colour /= sum.opacity;
  sum.opacity = one_opacity ? first : std::min(sum.opacity, 1.0);  // shares may sum to 1 + 1e-16
  return sum;
}

Node LabelledMedium::node(const Vec3& p_world, const FieldView& field,
                          const transfer::TransferFunction& transfer) const {
  const Mixed m = mixed(world_to_index_ * (p_world - labels_.geometry.origin));
  Node node;
  if (!(m.opacity > 0)) return node;
  node.opacity = m.opacity;
  node.colour = m.colour;
  if (style_.times_transfer) {
    node.value = field.value(p_world);
    node.opacity *= transfer.opacity(node.value);
    node.colour = node.colour.cwiseProduct(transfer.colour(node.value));
  }
  return node;
}

Visibility LabelledMedium::visibility() const {
  volume::Volume seen = volume::allocate(volume::VoxelType::u8, labels_.geometry);
  auto& voxels = std::get<volume::Grid<std::uint8_t>>(seen.grid).voxels;
  for (std::size_t n = 0; n < voxels.size(); ++n) voxels[n] = looks_[labels_.voxels[n]].opacity > 0;
  const transfer::TransferFunction as_is({{0, Vec3::Ones()}}, {{0.25, 0}, {0.75, 1}});
  return render::visibility(index::macrocells(seen), as_is);
}

}  // namespace vol::render
