#pragma once
#include <optional>

#include "render/isosurface_rays.h"
#include "wavelet/line_field.h"

namespace vol::render {

/// What a search along a ray knows of the field between two points.
enum class SurfaceBound {
  global,    ///< one Lipschitz bound for the whole box, as Gross et al. print it: for comparison
  local,     ///< the same bound of the terms at hand, along the ray, anew on every interval
  bernstein  ///< local, and between knots the field's own polynomial, whose roots are isolated
};

struct ExpansionSurfaceOptions {
  SurfaceBound bound = SurfaceBound::bernstein;
  std::optional<double> tolerance = std::nullopt;  ///< world length; 1/1000 of the smallest spacing
  bool close = false;  ///< what is inside (f >= isovalue) at the box's border ends there
};

/// The isosurface f = isovalue of a wavelet expansion, met by rays, its volume never rebuilt (Gross, Lippert,
/// Dreger & Koch 1995, section 4, after Kalra & Barr 1989).
///
/// A ray's chord is halved until each part [a, b] of width w is decided. With L, G bounds of |f'|, |f''|
/// along it, J, K sums of the jumps of f and of f', and F = f - isovalue:
///   - F(a), F(b) on one side, |F(a) + F(b)| > L w + J:                      no change of side between
///   - the same, J = 0, min(|F(a)|, |F(b)|) > G w^2/8 + K w/4:               none either (not `global`)
///   - J = 0, |f'(a) + f'(b)| > G w + K:  f is monotone: one change, or none, as F(a) and F(b) say
///   - w at most the tolerance: one, or none, as F(a) and F(b) say; if none, the ray is `undecided`
/// The bounds hold but for rounding, which they are widened by. So the first change of side is found, unless
/// what lies between it and the next one is no wider than the tolerance.
///
/// With `bernstein` an interval that is not decided so is cut at a knot instead of its middle, and where no
/// knot is left within, f is a polynomial of degree 9, written in the Bernstein basis and searched by
/// first_crossing(): there nothing is missed down to rounding.
///
/// Refers to the expansion, which must live longer.
class ExpansionSurface {
 public:
  /// \throws vol::Error on an isovalue or a tolerance that is not finite, and a tolerance not above 0
  ExpansionSurface(const wavelet::Expansion& expansion, double isovalue,
                   const ExpansionSurfaceOptions& options = {});

  using Hit = IsosurfaceRays::Hit;
  struct Counts {
    std::int64_t rays = 0;  ///< that meet the box
    std::int64_t hits = 0;
    std::int64_t evaluations = 0;  ///< of f and f' at a point of a ray
    std::int64_t bounds = 0;       ///< intervals for which L, G, J and K were worked out
    std::int64_t polynomials = 0;  ///< made between knots
    std::int64_t terms = 0;        ///< looked at in all of these
    std::int64_t undecided = 0;    ///< rays that may touch the surface without passing through it
    Counts& operator+=(const Counts& other);
  };

  /// The first change of side on the chord, to within 1e-6 of the tolerance. The normal is that of the
  /// analytic gradient (43); where that vanishes, as everywhere with haar, of the differences over 1/1000
  /// sample to either side along each axis. On a closed border it is the border's.
  [[nodiscard]] std::optional<Hit> first_hit(const camera::Ray& ray, const Chord& chord,
                                             Counts& counts) const;

  [[nodiscard]] const volume::FieldBounds& bounds() const { return expansion_.bounds(); }
  [[nodiscard]] double tolerance() const { return tolerance_; }  ///< world length
  /// (45) over the whole box, in value per index step.
  [[nodiscard]] double global_lipschitz() const { return global_.slope; }

 private:
  class Search;

  const wavelet::Expansion& expansion_;
  wavelet::LineTerms terms_;
  wavelet::LineTerms::Global global_;
  RayBox box_;
  double isovalue_;
  ExpansionSurfaceOptions options_;
  double tolerance_;
};

struct ExpansionSurfaceImage {
  image::Image image;  ///< channels as IsosurfaceImage's
  ExpansionSurface::Counts counts;
};

/// One ray a pixel, lit as draw_isosurface() lights.
[[nodiscard]] ExpansionSurfaceImage draw_expansion_surface(const ExpansionSurface& surface,
                                                           const Scene& scene, const Vec3& colour, int width,
                                                           int height);

}  // namespace vol::render
