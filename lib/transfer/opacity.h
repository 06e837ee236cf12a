#pragma once

namespace vol::transfer {

/// Extinction sigma_t = -log1p(-opacity) / reference_length, in 1/world length: the constant extinction that
/// gives `opacity` over one reference length (Max 1995). Infinite for opacity 1.
/// \param opacity           in [0, 1]
/// \param reference_length  world length, > 0
[[nodiscard]] double extinction(double opacity, double reference_length);

/// Opacity of a segment of length `step`, given `opacity` for length `reference_length`.
/// With constant extinction, transmittance multiplies along the ray: 1 - a = (1 - a0)^(step / reference_length),
/// evaluated as -expm1(r log1p(-a0)), r = step / reference_length, so that small opacities keep their digits.
[[nodiscard]] double corrected_opacity(double opacity, double step, double reference_length);

/// Mean over a segment of -log1p(-a), where the opacity a runs linearly from a0 to a1: the optical depth of the
/// segment, per reference length, of an opacity ramp. With u = 1 - a the antiderivative of -log u is u - u log u, so
///   mean = 1 + (u1 log u1 - u0 log u0) / (u0 - u1),
/// finite even where one end is opaque (u log u -> 0); 0 or infinite only for a transparent or an opaque segment.
/// Close ends are evaluated by the series of the mean of log about the midpoint.
[[nodiscard]] double mean_ramp_depth(double a0, double a1);

}  // namespace vol::transfer
