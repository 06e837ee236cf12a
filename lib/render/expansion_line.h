#pragma once
#include "camera/camera.h"
#include "render/ray_box.h"
#include "render/ray_polynomial.h"
#include "wavelet/line_field.h"

namespace vol::render {

/// A wavelet expansion along rays: between any two knots that a ray crosses it is one polynomial of degree 9
/// at most, the sum of the terms that the ray meets there (Gross, Lippert, Dreger & Koch 1995, eq. 31-35),
/// exact but for rounding of the sum of |terms|. The knots of all levels are among those of the finest level
/// around. Keeps its memory from ray to ray; not for two threads at a time. Refers to the terms, which must
/// live longer.
class ExpansionLine {
 public:
  explicit ExpansionLine(const wavelet::LineTerms& terms) : terms_(terms), line_(terms) {}

  /// Hands over the pieces of a chord, front to back and without gaps; where no term is, they are 0.
  void visit(const camera::Ray& ray, const Chord& chord, const PieceSink& sink);

  /// While the sink looks at a piece: world gradient at t of it (Gross et al., eq. 43). Where f is
  /// constant, the terms' slopes cancel to rounding, which points anywhere: components below 1e-13 of the sum
  /// of magnitudes are 0.
  [[nodiscard]] Vec3 gradient(double t);

  [[nodiscard]] std::int64_t terms_met() const { return met_; }  ///< of all rays so far
  [[nodiscard]] std::int64_t pieces() const { return pieces_; }

 private:
  bool part(double a, double b, std::size_t from, std::size_t to, const PieceSink& sink);

  const wavelet::LineTerms& terms_;
  wavelet::LineField line_;
  wavelet::LineField::List list_;
  std::size_t from_ = 0, to_ = 0;  // of the piece at hand, in the list
  double middle_ = 0;              // of the chord: the line counts from there
  Mat3 world_to_index_;
  std::int64_t met_ = 0, pieces_ = 0;
};

}  // namespace vol::render
