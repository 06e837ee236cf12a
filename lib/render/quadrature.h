#pragma once
#include "render/optics.h"
#include "render/options.h"
#include "render/shading.h"

namespace vol::render {

/// One reconstruction of the field on a ray.
struct Node {
  double value = 0;
  double opacity = 0;          ///< for one reference length
  Vec3 colour = Vec3::Zero();  ///< of the transfer function, not yet lit
  Lit lit;                     ///< what shading makes of it; the identity without shading
};

/// What a segment does to light: I' = I + T emission, A' = A + T alpha, T' = T transmittance.
struct Segment {
  Vec3 emission = Vec3::Zero();
  double alpha = 0;  ///< 1 - transmittance, with its own digits
  double transmittance = 1;
  double optical_depth = 0;
};

/// The rules for I = integral of c sigma_t T ds over one segment of length h, T = 1 at its start. With
/// r = h / reference_length and D(a0, a1) = mean_ramp_depth(a0, a1) of transfer/opacity.h:
///
/// rectangle (order 1). The left node alone: tau = -r log1p(-a0), emission = c0 (1 - e^-tau).
///
/// trapezoid (order 2). Extinction linear between the nodes: tau = r (s0 + s1) / 2, s = -log1p(-a); where an
/// end is opaque, opacity linear instead: tau = r D(a0, a1), which is finite. emission = c (1 - e^-tau), c
/// the nodes' colours weighted by extinction, (s0 c0 + s1 c1) / (s0 + s1): then c sigma_t is linear between
/// the nodes too, and a node with opacity 0 need not be sampled where that is known. An opaque end takes all
/// the weight. Both ends opaque: the segment is, and emission = c0.
///
/// preintegrated (order 2). The field linear between the nodes; the integral itself, exactly: the segment is
/// cut where the field crosses the transfer function's points. On a piece of ratio r whose opacity runs
/// linearly from a0 to a1 and whose colour from c0 to c1, tau = r D(a0, a1) and, by parts, with u in [0,1]
/// along the piece and rho(u) = r (1 - u) D(a(u), a1) the depth still ahead,
///   emission = c0 (1 - e^-tau) + (c1 - c0) integral_0^1 (e^-(tau - rho(u)) - e^-tau) du,
/// the last by adaptive Gauss-Kronrod quadrature to 1e-13, cut at its logarithmic ends. A stretch of values
/// with opacity 1 is opaque and adds T c where it is entered; a single value with opacity 1 is a set of no
/// length and is passed, as the integral does.
///
/// Shading: rectangle and trapezoid take the nodes' lit colours; preintegrated averages their diffuse factors
/// and highlights.
[[nodiscard]] Segment rectangle(const Node& left, double h, const Optics& optics);
[[nodiscard]] Segment trapezoid(const Node& left, const Node& right, double h, const Optics& optics);
[[nodiscard]] Segment preintegrated(const Node& left, const Node& right, double h, const Optics& optics);

/// The piece of `preintegrated`: opacity a0 to a1, colour c0 to c1, r = length / reference length.
[[nodiscard]] Segment ramp(double a0, double a1, const Vec3& c0, const Vec3& c1, double r);

}  // namespace vol::render
