#pragma once
#include <functional>
#include <vector>

#include "render/gauss.h"
#include "render/optics.h"
#include "render/options.h"
#include "render/picture.h"
#include "render/ray_polynomial.h"
#include "render/shading.h"

namespace vol::render {

/// Hands the pieces of a chord to a sink; \returns evaluations of the field that this took itself.
using PieceSource = std::function<std::int64_t(const camera::Ray&, const Chord&, const PieceSink&)>;

/// Models xray and mip of a chord's pieces: their integral in closed form; the largest value, to `tolerance`
/// times the largest |f|.
[[nodiscard]] Pixel reference_xray(const camera::Ray& ray, const Chord& chord, const PieceSource& pieces,
                                   RenderCounts& counts);
[[nodiscard]] Pixel reference_mip(const camera::Ray& ray, const Chord& chord, const PieceSource& pieces,
                                  double tolerance, RenderCounts& counts);

/// The emission-absorption integral of one ray, front to back over polynomial pieces of the field:
///   I = integral of c sigma_t T ds,  T = exp(-integral of sigma_t),  sigma_t = -log1p(-a) / reference
///   length.
///
/// A piece is cut where the field crosses the transfer function's points, so that between cuts a and c are
/// one polynomial each. There sigma_t is sampled at Gauss-Legendre points; collocation gives the optical
/// depth at the points themselves, and the same points integrate c sigma_t T. A panel is halved until the sum
/// of
///   what the two highest Legendre coefficients of sigma_t carry (times what is still to come behind it),
///   what those of c sigma_t T carry, and
///   | integral of sigma_t T - (1 - e^-tau) |, which is zero for the exact integral whatever sigma_t is and
///   catches a medium so dense that all of it happens between two points,
/// is within the panel's share of the tolerance. Where a approaches 1, sigma_t has an integrable logarithm,
/// which halving resolves. The errors accepted are added up: the estimate. Once T times the brightest colour
/// is below a thousandth of the tolerance, the rest of the ray is left out, and counted as error.
///
/// A stretch where the opacity is 1 is opaque: it adds T c where it is entered and ends the ray.
class ReferenceIntegral {
 public:
  using Light = std::function<Lit(double t)>;

  /// \param light  of the point at t, or empty for none
  /// \param headlight  light comes along the ray: |N.L| then has its kinks where the field's slope along the
  /// ray
  ///                   changes sign, and pieces are cut there too
  /// \param brightest  upper bound of a lit colour's components
  /// \param before     what the ray gathered in front of the first piece
  ReferenceIntegral(const Optics& optics, double tolerance, double ray_length, double brightest, Light light,
                    bool headlight = false, const Beam& before = {});

  /// Adds the next piece. \returns false once nothing more can be seen.
  bool add(const RayPiece& piece);
  [[nodiscard]] const Pixel& pixel() const { return pixel_; }
  [[nodiscard]] Beam beam() const { return {pixel_, transmittance_}; }
  [[nodiscard]] std::int64_t evaluations() const { return evaluations_; }

 private:
  struct Panel {
    double depth = 0;              ///< optical depth
    Vec3 emission = Vec3::Zero();  ///< integral of c sigma_t T, T = 1 at the panel's start
    double error_depth = 0;
    double error_emission = 0;
  };
  [[nodiscard]] Panel evaluate(const RayPiece& piece, const OpticsInterval& optics, double u0, double u1);
  [[nodiscard]] double extinction(const RayPiece& piece, const OpticsInterval& optics, double u) const;
  void integrate(const RayPiece& piece, const OpticsInterval& optics, double u0, double u1, double tolerance,
                 int depth);
  void accept(const RayPiece& piece, const OpticsInterval& optics, double u0, double u1, const Panel& panel,
              double error);
  void enter_opaque(const RayPiece& piece, const OpticsInterval& optics, double u);

  const Optics& optics_;
  double tolerance_;
  double ray_length_;
  double brightest_;
  Light light_;
  bool headlight_;
  Pixel pixel_;
  double transmittance_ = 1;
  bool done_ = false;
  std::int64_t evaluations_ = 0;
  std::vector<double> cuts_;
};

}  // namespace vol::render
