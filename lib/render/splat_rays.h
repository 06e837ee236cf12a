#pragma once
#include <array>
#include <optional>
#include <vector>

#include "render/labelled_medium.h"
#include "render/ray_box.h"
#include "volume/splat_field.h"

namespace vol::render {

/// The contour of splatted voxels, met by rays; each splat has its label's colour.
class SplatRays {
 public:
  /// \param looks      of label 0, 1, ...: their colours
  /// \param threshold  of the contour, > 0; the largest value of one splat is 1
  /// \throws vol::Error on another threshold
  SplatRays(volume::SplatField field, const std::vector<LabelLook>& looks, double threshold);

  struct Hit {
    double t;       ///< world length along the ray
    Vec3 position;  ///< world
    Vec3 normal;    ///< unit, from inside to outside; 0 where the gradient vanishes
    Vec3 colour;    ///< the mean of the splats' colours there, weighted by their values; not lit
  };

  /// Where f first changes side, f >= threshold or not, on the ray from t_min on, wherever the camera sees.
  /// Along a ray every splat is a polynomial of degree 6 between its ends; between two ends of any of them so
  /// is the sum, and its Bernstein coefficients find the first root: no crossing is stepped over
  /// (first_crossing()). A stretch is halved by the number of ends in it until it has none, or until bounds
  /// of the sum are on one side; what goes on beyond both its ends is added once, so n splats take n log n
  /// steps. \param undecided  if given, set where the ray may touch the contour without passing through it
  [[nodiscard]] std::optional<Hit> first_hit(const camera::Ray& ray, double t_min,
                                             bool* undecided = nullptr) const;

  [[nodiscard]] const volume::SplatField& field() const { return field_; }
  /// Of each component, the largest of any colour.
  [[nodiscard]] const Vec3& brightest() const { return brightest_; }

 private:
  struct Stretch;  // of a ray, with its splats
  [[nodiscard]] Hit hit_at(const camera::Ray& ray, double t) const;

  volume::SplatField field_;
  RayBox box_;
  double threshold_;
  std::array<Vec3, 256> colours_;
  Vec3 brightest_ = Vec3::Zero();
};

}  // namespace vol::render
