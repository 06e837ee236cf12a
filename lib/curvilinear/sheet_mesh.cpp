#include "curvilinear/sheet_mesh.h"

#include <algorithm>

namespace vol::curvilinear {
namespace {

/// Pieces along u, v and w by which chords miss the solid by at most a tenth of the throttle's pixels, and
/// values by the tolerance: h^2 / 8 of the second derivative along an axis (at most 6 times the largest
/// second difference of control points), h^2 / 4 of the mixed one of u and v (9 times the mixed difference)
/// across a piece cut in two.
std::array<double, 3> flat_pieces(const LargestDifferences& d, const Point4& centre, const Screen& screen,
                                  const SheetFineness& fineness) {
  constexpr double kShare = 0.1;
  const double position = screen.pixels(centre.head<3>()) / (kShare * fineness.throttle);
  const double value = fineness.value_tolerance > 0 ? 1 / fineness.value_tolerance : 0;
  const auto measure = [&](const Eigen::Array4f& difference) {
    const Eigen::Array4d e = difference.cast<double>();
    return std::max(position * e.head<3>().matrix().norm(), value * e[3]);
  };
  // The sum of the three errors across a surface within 1: half for the bends, half for the twist.
  std::array<double, 3> pieces{};
  for (std::size_t a = 0; a < 3; ++a) pieces[a] = std::max(1.0, std::sqrt(6 * measure(d.second[a]) / 2));
  const double mixed = 9 * measure(d.mixed) / 4 / (pieces[0] * pieces[1]);
  if (mixed > 0.5) {
    for (std::size_t a = 0; a < 2; ++a) pieces[a] *= std::sqrt(2 * mixed);
  }
  return pieces;
}

/// Of the corners: an origin near all of the solid.
Point4 middle(const Solid& solid) {
  Point4 sum = Point4::Zero();
  for (const std::size_t n : {0, 3, 12, 15, 48, 51, 60, 63}) sum += solid.b[n];
  return sum / 8;
}

Lattice surfaces(const Solid& solid, const Point4& centre, const Screen& screen,
                 const SheetFineness& fineness) {
  const LargestDifferences differences(solid, centre);
  const Extents e = extents(solid, differences, screen);
  const std::array<double, 3> pieces = flat_pieces(differences, centre, screen, fineness);
  Lattice lattice;
  for (std::size_t a = 0; a < 3; ++a) {
    // Pieces of less than a pixel show no more.
    const double extent = a < 2 ? e.across[a] : e.length[a];
    lattice.steps[a] =
        step_count(std::min(std::max(pieces[a], e.across[a] / screen.linear_pixels()), extent), 1);
  }
  double sheets = e.length[2] / fineness.throttle;
  if (fineness.sheets_a_value < std::numeric_limits<double>::infinity())
    sheets = std::min(sheets, 3 * static_cast<double>(differences.first[2][3]) * fineness.sheets_a_value);
  lattice.steps[2] = std::max(lattice.steps[2], step_count(sheets, 1));
  for (std::size_t a = 0; a < 3; ++a) lattice.counts[a] = lattice.steps[a] + 1;
  return lattice;
}

}  // namespace

SheetMaker::SheetMaker(const Solid& solid, const Screen& screen, const SheetFineness& fineness)
    : screen_(screen),
      depth_scale_(fineness.depth_scale),
      origin_(middle(solid)),
      lattice_(surfaces(solid, origin_, screen, fineness)) {
  origin_distance_ = distance(origin_.head<3>());
  if (*std::max_element(lattice_.steps.begin(), lattice_.steps.end()) <= kFloatSteps) {
    differences_.emplace<ForwardDifferences<float>>(solid, origin_, lattice_);
  } else {
    differences_.emplace<ForwardDifferences<double>>(solid, origin_, lattice_);
  }
}

double SheetMaker::distance(const Vec3& view) const {
  return view.dot(screen_.direction(view));
}

template <class T>
void SheetMaker::append_surface(ForwardDifferences<T>& f, std::vector<SheetVertex>& vertices) const {
  f.each_row([&](int, Differences<T>& row) {
    for (int u = 0; u < lattice_.counts[0]; ++u, row.advance()) {
      const Point4 p = row.value().matrix().template cast<double>() + origin_;
      const Vec3 view = p.head<3>();
      const Eigen::Vector2d image = screen_.project(view);
      vertices.push_back({image.x(), image.y(),
                          static_cast<float>((distance(view) - origin_distance_) * depth_scale_),
                          static_cast<float>(p[3])});
    }
  });
  f.next_plane();
}

std::int64_t SheetMaker::make(std::size_t budget, SheetMeshes& meshes) {
  std::vector<SheetVertex>& vertices = meshes.vertices;
  SheetMesh mesh{lattice_.counts[0],
                 lattice_.counts[1],
                 made_ == 0 ? 0 : 1,
                 vertices.size(),
                 made_ == 0,
                 false,
                 0,
                 0,
                 0,
                 0};
  const auto surface = static_cast<std::size_t>(mesh.columns) * static_cast<std::size_t>(mesh.rows);
  vertices.insert(vertices.end(), last_.begin(), last_.end());
  const int before = made_;
  do {
    std::visit(
        [&](auto& f) {
          if constexpr (!std::is_same_v<std::decay_t<decltype(f)>, std::monostate>)
            append_surface(f, vertices);
        },
        differences_);
    ++made_;
    ++mesh.surfaces;
  } while (!done() && (mesh.surfaces < 2 || vertices.size() < budget));
  mesh.ends = done();
  if (!done()) last_.assign(vertices.end() - static_cast<std::ptrdiff_t>(surface), vertices.end());
  const SheetVertex* v = &vertices[mesh.first];
  mesh.left = mesh.right = v->x;
  mesh.top = mesh.bottom = v->y;
  for (; v != vertices.data() + vertices.size(); ++v) {
    mesh.left = std::min(mesh.left, v->x);
    mesh.right = std::max(mesh.right, v->x);
    mesh.top = std::min(mesh.top, v->y);
    mesh.bottom = std::max(mesh.bottom, v->y);
  }
  meshes.meshes.push_back(mesh);
  return static_cast<std::int64_t>(surface) * (made_ - before);
}

}  // namespace vol::curvilinear
