#pragma once
#include <span>
#include <variant>
#include <vector>

#include "curvilinear/forward_difference.h"
#include "curvilinear/sheet_parts.h"

// Private to lib/curvilinear: sheets of physical thickness.
namespace vol::curvilinear {

/// A point of a surface of constant w in the picture, in pixels, with its distance along the ray in reference
/// lengths, from any origin of its solid, and the value as TransferTable looks it up.
struct SheetVertex {
  double x, y;
  float depth, value;
};

/// Surfaces of constant w of a solid, front to back: vertices[first + column + columns (row + rows surface)].
/// Between each and the next lies a sheet.
struct SheetMesh {
  int columns, rows, surfaces;
  std::size_t first;
  bool starts, ends;  ///< else the solid's earlier surfaces came before, the last of them here again
  double left, right, top, bottom;  ///< of the vertices, pixels
};

struct SheetMeshes {
  std::vector<SheetVertex> vertices;
  std::vector<SheetMesh> meshes;
};

/// How finely sheets are drawn.
struct SheetFineness {
  double throttle;         ///< pixels from sheet to sheet
  double value_tolerance;  ///< by which values between points may miss the solid's, as the table has them
  double depth_scale;      ///< reference lengths of a unit of view coordinates
  /// Sheets for a change of the value by 1: a solid that is deeper by far than the picture has no more than
  /// its shape and its values ask for.
  double sheets_a_value = std::numeric_limits<double>::infinity();
};

/// Makes the surfaces between the sheets of a solid (oriented) one after another, w = i / n, by their points.
/// Chords between points miss the solid by a tenth of the throttle's pixels at most, and values by the
/// tolerance.
class SheetMaker {
 public:
  SheetMaker(const Solid& solid, const Screen& screen, const SheetFineness& fineness);

  [[nodiscard]] bool done() const { return made_ == lattice_.counts[2]; }
  /// Surfaces until there are `budget` vertices or all are made; a sheet at least. \returns the points it
  /// took
  std::int64_t make(std::size_t budget, SheetMeshes& meshes);

 private:
  const Screen& screen_;
  double depth_scale_, origin_distance_;
  Point4 origin_;
  Lattice lattice_;
  int made_ = 0;
  std::variant<std::monostate, ForwardDifferences<float>, ForwardDifferences<double>> differences_;
  std::vector<SheetVertex> last_;  ///< surface of the mesh before

  template <class T>
  void append_surface(ForwardDifferences<T>& f, std::vector<SheetVertex>& vertices) const;
  [[nodiscard]] double distance(const Vec3& view) const;
};

/// Draws sheets into the rows of a band by scan conversion, in their order. A sheet is the closed polyhedron
/// of triangles between two surfaces and along the solid's sides; a ray through a pixel's centre goes through
/// it from triangle to triangle, neighbours' edges met neither twice nor never. So lengths are those of the
/// polyhedron, at silhouettes too. A
/// sheet's value on a ray is linear between the two ends', its colour that of the middle.
void scan_sheets(std::span<const SheetMeshes* const> meshes, const TransferTable& table, Band& band);

}  // namespace vol::curvilinear
