#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "render/field_view.h"
#include "render/quadrature.h"
#include "render/visibility.h"
#include "volume/volume.h"

namespace vol::render {

/// How one label looks. By default it is not seen.
struct LabelLook {
  Vec3 colour{1, 1, 1};  ///< linear RGB
  double opacity = 0;    ///< for one reference length, in [0, 1]
};

/// nearest: a point has the label of the nearest sample, the upper one halfway. interpolated: it belongs to
/// label l to the share w_l that trilinear interpolation of the label's indicator has there; shares sum to 1.
enum class Membership { nearest, interpolated };

struct LabelStyle {
  std::vector<LabelLook> looks;  ///< of label 0, 1, ...; labels beyond them are not seen
  Membership membership = Membership::interpolated;
  /// Opacity and colour of the labels times those of the transfer function, which a white label of opacity 1
  /// leaves as they are; else the labels alone.
  bool times_transfer = false;
};

/// \throws vol::Error unless there is one label for every sample of the volume
void require_dims_of(const volume::GridGeometry& labels, const volume::GridGeometry& volume);

/// A volume as its labels make it seen. A point that belongs to labels by shares w_l has, after Drebin,
/// Carpenter & Hanrahan 1988, for one reference length
///   opacity  a = sum_l w_l a_l,   colour  c = sum_l w_l a_l c_l / a:
/// opacity is linear between samples as it is between a transfer function's points, and it is 1 exactly where
/// only opaque labels have a share.
class LabelledMedium {
 public:
  /// The labels stand where the samples of a volume of this geometry do, whatever place their own file gives.
  /// \throws vol::Error on other dims than the volume's, an opacity beyond 0 to 1, and a colour that is
  ///         negative or not finite
  LabelledMedium(volume::Grid<std::uint8_t> labels, const volume::GridGeometry& geometry, LabelStyle style);

  [[nodiscard]] const volume::Grid<std::uint8_t>& labels() const { return labels_; }
  [[nodiscard]] const LabelLook& look(std::uint8_t label) const { return looks_[label]; }
  [[nodiscard]] bool times_transfer() const { return style_.times_transfer; }

  /// A node at a world point (clamped to the box), not lit. The field is asked for its value only where that
  /// counts.
  [[nodiscard]] Node node(const Vec3& p_world, const FieldView& field,
                          const transfer::TransferFunction& transfer) const;

  /// Where no label is seen, whatever the value.
  [[nodiscard]] Visibility visibility() const;

 private:
  struct Mixed {
    double opacity = 0;
    Vec3 colour = Vec3::Zero();
  };
  [[nodiscard]] Mixed mixed(const Vec3& p_index) const;

  volume::Grid<std::uint8_t> labels_;
  Mat3 world_to_index_;
  LabelStyle style_;
  std::array<LabelLook, 256> looks_{};
};

}  // namespace vol::render
