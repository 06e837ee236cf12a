#pragma once
#include <functional>
#include <optional>

#include "index/macrocells.h"
#include "render/options.h"
#include "render/ray_box.h"
#include "render/ray_polynomial.h"
#include "render/raycast.h"

namespace vol::render {

/// Where p - value first changes between the sides "at least 0" and "below 0" on [0, 1], to within 1e-14.
///
/// By the Bernstein coefficients: all on one side, and the polynomial is; one change of side among them and
/// there is one root; else both halves are searched, the first one first. So a pair of roots cannot be
/// skipped, unless it is closer than 2^-46: then `undecided` is set. A zero coefficient is on the side
/// "at least", which is the isosurface's rule for ties.
[[nodiscard]] std::optional<double> first_crossing(const Bernstein& p, double value,
                                                   bool* undecided = nullptr);

/// The isosurface f = isovalue of a reconstructed volume, met by rays. Refers to the volume, which must live
/// longer.
class IsosurfaceRays {
 public:
  /// \param close  what is inside (f >= isovalue) at the volume's border ends there: the border is surface
  /// too \throws vol::Error on NaN or infinity in the volume, and an isovalue that is not finite
  IsosurfaceRays(const volume::Volume& volume, volume::Reconstruction reconstruction, double isovalue,
                 bool close);

  struct Hit {
    double t;       ///< world length along the ray
    Vec3 position;  ///< world
    Vec3 normal;    ///< unit, from inside to outside
  };
  struct Counts {
    std::int64_t rays = 0;  ///< that meet the volume
    std::int64_t hits = 0;
    std::int64_t cells = 0;      ///< whose polynomial was made: not those with all samples on one side
    std::int64_t undecided = 0;  ///< rays that may touch the surface without passing through it
    Counts& operator+=(const Counts& other);
  };

  /// The first change of side on the chord: from cell to cell by the polynomial that the field is there
  /// (degree 3 for trilinear, 9 for the cubics), cells in macrocells whose range excludes the isovalue left
  /// out. A change between two cells, where rounding puts it, is a hit too. The isovalue is subtracted from
  /// the samples before they are interpolated, so that plateaus at it are inside, whatever the rounding.
  ///
  /// The normal is the gradient's in the cell of the crossing; where that vanishes, as on the rim of a
  /// plateau, the gradient's a little outside. On a closed border it is the border's. A chord that begins
  /// inside the box (its eye is there) has no border where it begins; what is inside from there to the box's
  /// other side ends there.
  [[nodiscard]] std::optional<Hit> first_hit(const camera::Ray& ray, const Chord& chord,
                                             Counts& counts) const;

  /// All changes of side on the chord, front to back, each as first_hit() would give it if the chord began
  /// between it and the one before; f returns false to stop. Sets `undecided` where the ray may touch the
  /// surface besides. Adds to counts.cells alone.
  void for_hits(const camera::Ray& ray, const Chord& chord, const std::function<bool(const Hit&)>& f,
                Counts& counts, bool& undecided) const;

  [[nodiscard]] const volume::FieldBounds& bounds() const { return bounds_; }

 private:
  [[nodiscard]] Hit hit_at(const camera::Ray& ray, const RayPiece& piece, double t) const;
  [[nodiscard]] bool begins_inside(const camera::Ray& ray, const Chord& chord) const;
  [[nodiscard]] Hit border_hit(const camera::Ray& ray, double t) const;

  /// The stretches of the chord through macrocells that the surface may cross, in order; f returns false to
  /// stop.
  template <class F>
  void for_crossed_stretches(const camera::Ray& ray, const Chord& chord, const F& f) const;

  const volume::GridGeometry& geometry_;
  volume::FieldBounds bounds_;
  Mat3 world_to_index_;
  GridPieces pieces_;  // of the field less the isovalue
  RayBox box_;
  bool close_;
  Dims macrocells_;
  std::vector<std::uint8_t> crossed_;  // macrocells whose range holds the isovalue
  Dims blocks_;
  std::vector<std::uint8_t> block_crossed_;  // blocks of kBlock^3 macrocells, of which one is crossed
};

struct IsosurfaceImage {
  /// R, G, B, A (lit colour, linear; A 1 on the surface), `depth` (world length along the ray, +infinity
  /// where there is none), `normal.x` .. `normal.z`, `position.x` .. `position.z` (world; 0 where there is
  /// none).
  image::Image image;
  IsosurfaceRays::Counts counts;
};

/// One ray a pixel; Blinn-Phong with the scene's shading (or its defaults), as vol-raycast lights.
[[nodiscard]] IsosurfaceImage draw_isosurface(const IsosurfaceRays& surface, const Scene& scene,
                                              const Vec3& colour, int width, int height);

}  // namespace vol::render
