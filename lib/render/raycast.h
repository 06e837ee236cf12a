#pragma once
#include "image/image.h"
#include "index/index_volume.h"
#include "render/field_view.h"
#include "render/labelled_medium.h"
#include "render/options.h"
#include "volume/volume.h"

namespace vol::render {

struct RenderResult {
  /// Channels R, G, B, A (colour premultiplied, background not yet behind it), `samples`, `depth`.
  ///   composite  the radiance I, A = 1 - T
  ///   xray, mip  the integral or the maximum in R = G = B; A = 1 where the ray meets the box
  ///   samples    reconstructions of f for the pixel (reference: evaluations of the cells' polynomials)
  ///   depth      t on the camera's ray (world length from the eye; orthographic: from the plane through the
  ///              target, so it may be negative) at which T falls to 0.5; mip: of the maximum; +infinity if
  ///              none
  image::Image image;
  RenderCounts counts;
  /// Reference only: estimate of the largest absolute error of a channel of a pixel. NaN where none is known.
  double error_estimate = 0;
  /// What cast the rays: "plain" (double, scalar), "packets" (float, SIMD) or "reference".
  const char* caster = "plain";
};

/// The plain ray caster: scalar, double, one ray after the other; the oracle of the fast ones.
///
/// Nodes t_i = t_entry + i h, i = 0 .. n, n = ceil((t_exit - t_entry) / h - 1e-9) and at least 1, t_n =
/// t_exit: the last segment is shorter (by less than 1e-9 h it may be longer, so that rounding adds no empty
/// one). quadrature.h defines what a segment contributes. A ray that touches the box in less than a length >
/// 0 misses.
///
/// With an index, node i is followed by node i + 2^L, L the entry of the cell that holds node i, or by the
/// last node where that is nearer: an index of zeros is the uniform picture bit for bit. Where empty space is
/// skipped, a ray in an invisible macrocell follows no entry but goes on at the first node that may be
/// visible. The index's cells are those of the grid whose outermost sample centres span the field's bounds.
///
/// A ray ends where its transmittance is at most `termination`; always where it is 0.
///
/// \throws vol::Error on options out of range, more than 1e9 nodes on a ray, an index of other dims than the
///         volume, a pixel that float cannot hold, quadratures `split` and `reference`, and, for a field that
///         is not a grid, a scene without reference_length (xray and mip need none)
[[nodiscard]] RenderResult raycast_plain(const FieldView& field, const Scene& scene,
                                         const RenderOptions& options,
                                         const index::IndexVolume* index = nullptr);
template <volume::FieldSampler F>
[[nodiscard]] RenderResult raycast_plain(const F& field, const Scene& scene, const RenderOptions& options,
                                         const index::IndexVolume* index = nullptr) {
  return raycast_plain(view_of(field), scene, options, index);
}
/// The same on a volume under options.reconstruction. With options.skip_empty (composite), a node is not
/// sampled if no segment it bounds can be visible, by the range of the voxels around (visibility.h): without
/// an index the picture is the same bit for bit. With labels, nodes are what these make of them, and where
/// none is seen nothing is sampled: quadratures rectangle and trapezoid, no index. \throws vol::Error also on
/// NaN or infinity in the volume.
[[nodiscard]] RenderResult raycast_plain(const volume::Volume& volume, const Scene& scene,
                                         const RenderOptions& options,
                                         const index::IndexVolume* index = nullptr,
                                         const LabelledMedium* labels = nullptr);

/// The truth: the integral itself, to options.tolerance, in double precision.
///
/// Along a ray the reconstructed field is a polynomial in each cell (degree 0 for nearest, 3 for trilinear, 9
/// for the cubics). It is cut where it crosses the points of the transfer function, and the smooth pieces are
/// integrated by adaptive Gauss quadrature with the optical depth nested (reference_integral.h). xray
/// integrates the polynomials in closed form; mip bounds them by their Bernstein coefficients. Steps and
/// early termination play no part. The tolerance is absolute, at least 1e-14 of the brightest colour, on the
/// colour scale (xray and mip: times the largest |f| met, and for xray the ray's length); the estimate of
/// what was reached is returned.
[[nodiscard]] RenderResult raycast_reference(const volume::Volume& volume, const Scene& scene,
                                             const RenderOptions& options);
/// `split` where packets do not go: the same cuts, with the reference's adaptive rule to kSplitTolerance.
[[nodiscard]] RenderResult raycast_split_plain(const volume::Volume& volume, const Scene& scene,
                                               const RenderOptions& options);
inline constexpr double kSplitTolerance = 1e-6;

/// The truth of a field in closed form: first the field along the ray is fitted by polynomials of degree 9 on
/// pieces halved until the fit is within 1e-14 of the largest |f| there, then as above. What a fit cannot
/// know: a feature narrower than 1/64 of the ray's chord that no probe hits.
[[nodiscard]] RenderResult raycast_reference(const FieldView& field, const Scene& scene,
                                             const RenderOptions& options);
template <volume::FieldSampler F>
[[nodiscard]] RenderResult raycast_reference(const F& field, const Scene& scene,
                                             const RenderOptions& options) {
  return raycast_reference(view_of(field), scene, options);
}

}  // namespace vol::render
