#pragma once
#include <array>

#include "curvilinear/screen.h"

namespace vol::curvilinear {

/// The two halves of a solid along an axis, by de Casteljau; both have the control points of the face between
/// them.
[[nodiscard]] std::array<Solid, 2> halves(const Solid& solid, std::size_t axis);

/// The part of a solid between two corners of a box of its parameters, by blossoms: parts that meet have the
/// control points of what they share.
[[nodiscard]] Solid part(const Solid& solid, const Vec3& low, const Vec3& high);

/// The axis along which a solid in view coordinates is best halved before its sheets are drawn; -1: none. It
/// is where sheets (of constant w, the solid being oriented) turn away from the eye somewhere, or nearly:
/// where at a corner the cosine of the ray with the sheet's normal is below 0.3 of that in the middle. Then
/// along the axis of the largest bend. A solid of less than kLeastPixels times the throttle is let be.
[[nodiscard]] int axis_to_halve(const Solid& oriented, const Screen& screen, double throttle);
inline constexpr double kLeastPixels = 8;

}  // namespace vol::curvilinear
