#pragma once
#include <span>
#include <variant>
#include <vector>

#include "curvilinear/forward_difference.h"
#include "curvilinear/sheet_parts.h"

// Private to lib/curvilinear: sheets as triangles between points of forward differences.
namespace vol::curvilinear {

/// A point of a sheet in the picture, in pixels, with the light's way through the sheet there in reference
/// lengths.
struct SheetVertex {
  double x, y;
  float value, depth;
};

/// Sheets of a solid, front to back: vertices[first + column + columns (row + rows sheet)].
struct SheetMesh {
  int columns, rows, sheets;
  std::size_t first;
  double left, right, top, bottom;  ///< of the vertices, pixels
};

struct SheetMeshes {
  std::vector<SheetVertex> vertices;
  std::vector<SheetMesh> meshes;
};

/// How finely sheets are drawn.
struct SheetFineness {
  double throttle;         ///< pixels from sheet to sheet
  double value_tolerance;  ///< by which values between points may miss the solid's
  double depth_scale;      ///< reference lengths of a unit of view coordinates
};

/// Makes the sheets of a solid (oriented) one after another. Each is the surface in the middle between its two
/// faces, w = (i + 1/2) / n, by its points, and carries the length between the faces along the ray.
///
/// Between points chords miss the solid by a twentieth of the throttle's pixels at most, and values by the
/// tolerance. Light crosses the slab of normal N and way across s, from face to face along w, by
/// |s . N| / |d . N|, d its direction; but no solid by more than its size.
class SheetMaker {
 public:
  SheetMaker(const Solid& solid, const Screen& screen, const SheetFineness& fineness);

  [[nodiscard]] bool done() const { return made_ == sheets_; }
  /// Sheets until there are `budget` vertices or all are made; one at least. \returns how many points that took
  std::int64_t make(std::size_t budget, SheetMeshes& meshes);

 private:
  template <class T>
  class Planes {
   public:
    Planes(const Solid& solid, const Point4& origin, const Lattice& lattice);
    /// The next sheet's vertices, appended.
    void next(const SheetMaker& maker, std::vector<SheetVertex>& vertices);

   private:
    using Point = typename ForwardDifferences<T>::Point;
    ForwardDifferences<T> f_;
    std::vector<Point> front_, middle_, back_;
    std::vector<Vec3> normals_;
    void read(std::vector<Point>& points);
  };

  const Screen& screen_;
  double depth_scale_, longest_;
  Point4 origin_;
  Lattice lattice_;
  int sheets_, made_ = 0;
  std::variant<std::monostate, Planes<float>, Planes<double>> planes_;
};

/// Draws sheets into the rows of a band by scan conversion, in their order: the pixels whose centres lie in a
/// triangle, neighbours' neither twice nor never; value and depth linear over it.
void scan_sheets(std::span<const SheetMeshes* const> meshes, const TransferTable& table, Band& band);

}  // namespace vol::curvilinear
