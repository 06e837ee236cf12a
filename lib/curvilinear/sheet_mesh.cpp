#include "curvilinear/sheet_mesh.h"

#include <algorithm>

namespace vol::curvilinear {
namespace {

/// Pieces along u and v by which chords miss the solid by at most a twentieth of the throttle's pixels, and
/// values by the tolerance: h^2 / 8 of the second derivative along an axis (at most 6 times the largest second
/// difference of control points), h^2 / 4 of the mixed one (9 times the mixed difference) across a piece cut
/// in two.
std::array<int, 2> flat_pieces(const Solid& solid, const Screen& screen, const SheetFineness& fineness,
                               const Extents& extents) {
  constexpr double kShare = 0.05;
  const double position = screen.pixels(solid(Vec3(0.5, 0.5, 0.5)).head<3>()) / (kShare * fineness.throttle);
  const double value = fineness.value_tolerance > 0 ? 1 / fineness.value_tolerance : 0;
  const Point4 scale(position, position, position, value);
  // The square of the larger: of the distance and of the value.
  const auto measure = [&](const Point4& difference) {
    const Point4 d = difference.cwiseProduct(scale);
    return std::max(d.head<3>().squaredNorm(), d[3] * d[3]);
  };
  double bends[2] = {}, twists = 0;
  constexpr std::size_t kStride[2] = {1, 4};
  for (std::size_t n = 0; n < 64; ++n) {
    const std::size_t at[2] = {n % 4, n / 4 % 4};
    for (std::size_t a = 0; a < 2; ++a) {
      const std::size_t s = kStride[a];
      if (at[a] < 2)
        bends[a] = std::max(bends[a], measure(solid.b[n] - 2 * solid.b[n + s] + solid.b[n + 2 * s]));
    }
    if (at[0] < 3 && at[1] < 3)
      twists = std::max(twists, measure(solid.b[n] - solid.b[n + 1] - solid.b[n + 4] + solid.b[n + 5]));
  }
  // The sum of the three errors within 1: half for the bends, half for the twist.
  double pieces[2];
  for (int a = 0; a < 2; ++a) pieces[a] = std::max(1.0, std::sqrt(6 * std::sqrt(bends[a]) / 2));
  const double mixed = 9 * std::sqrt(twists) / 4 / (pieces[0] * pieces[1]);
  if (mixed > 0.5) {
    for (double& n : pieces) n *= std::sqrt(2 * mixed);
  }
  std::array<int, 2> counts{};
  for (std::size_t a = 0; a < 2; ++a) {
    // Pieces of less than a pixel show no more.
    const double n =
        std::min(std::max(pieces[a], extents.across[a] / screen.linear_pixels()), extents.across[a]);
    counts[a] = step_count(n, 1);
  }
  return counts;
}

}  // namespace

template <class T>
SheetMaker::Planes<T>::Planes(const Solid& solid, const Point4& origin, const Lattice& lattice)
    : f_(solid, origin, lattice) {
  read(front_);
}

template <class T>
void SheetMaker::Planes<T>::read(std::vector<Point>& points) {
  points.clear();
  const Lattice& lattice = f_.lattice();
  f_.each_row([&](int, Differences<T>& row) {
    for (int u = 0; u < lattice.counts[0]; ++u, row.advance()) points.push_back(row.value());
  });
}

template <class T>
void SheetMaker::Planes<T>::next(const SheetMaker& maker, std::vector<SheetVertex>& vertices) {
  f_.next_plane();
  read(middle_);
  f_.next_plane();
  read(back_);
  const auto columns = static_cast<std::size_t>(f_.lattice().counts[0]),
             rows = static_cast<std::size_t>(f_.lattice().counts[1]);
  const auto local = [](const Point& p) { return Vec3(p.template head<3>().template cast<double>().matrix()); };
  // Twice the vector area of each piece, by its diagonals; a vertex has the sum of those around it.
  normals_.assign(columns * rows, Vec3::Zero());
  for (std::size_t v = 0; v + 1 < rows; ++v) {
    for (std::size_t u = 0; u + 1 < columns; ++u) {
      const std::size_t n = u + columns * v;
      const Vec3 normal = local(middle_[n + columns + 1] - middle_[n])
                              .cross(local(middle_[n + columns] - middle_[n + 1]));
      for (const std::size_t corner : {n, n + 1, n + columns, n + columns + 1}) normals_[corner] += normal;
    }
  }
  for (std::size_t n = 0; n < middle_.size(); ++n) {
    const Point4 p = middle_[n].matrix().template cast<double>() + maker.origin_;
    const Vec3 view = p.head<3>();
    const double l = std::abs(local(back_[n] - front_[n]).dot(normals_[n]) /
                              maker.screen_.direction(view).dot(normals_[n]));
    const Eigen::Vector2d image = maker.screen_.project(view);
    vertices.push_back({image.x(), image.y(), static_cast<float>(p[3]),
                        static_cast<float>((l < maker.longest_ ? l : maker.longest_) * maker.depth_scale_)});
  }
  front_.swap(back_);
}

SheetMaker::SheetMaker(const Solid& solid, const Screen& screen, const SheetFineness& fineness)
    : screen_(screen),
      depth_scale_(fineness.depth_scale),
      longest_(solid.hull().size().norm()),
      origin_(solid(Vec3(0.5, 0.5, 0.5))) {
  const Extents e = extents(solid, screen);
  const std::array<int, 2> pieces = flat_pieces(solid, screen, fineness, e);
  sheets_ = std::min(kMostSteps / 2, step_count(e.length[2], fineness.throttle));
  // The planes of the lattice are in turn faces and middles of the sheets.
  lattice_ = {
      {pieces[0], pieces[1], 2 * sheets_}, {pieces[0] + 1, pieces[1] + 1, 2 * sheets_ + 1}, Vec3::Zero()};
  if (std::max({pieces[0], pieces[1], 2 * sheets_}) <= kFloatSteps) {
    planes_.emplace<Planes<float>>(solid, origin_, lattice_);
  } else {
    planes_.emplace<Planes<double>>(solid, origin_, lattice_);
  }
}

std::int64_t SheetMaker::make(std::size_t budget, SheetMeshes& meshes) {
  SheetMesh mesh{lattice_.counts[0], lattice_.counts[1], 0, meshes.vertices.size(), 0, 0, 0, 0};
  const std::int64_t plane = std::int64_t{mesh.columns} * mesh.rows;
  std::int64_t points = made_ == 0 ? plane : 0;
  do {
    if (auto* planes = std::get_if<Planes<float>>(&planes_)) planes->next(*this, meshes.vertices);
    if (auto* planes = std::get_if<Planes<double>>(&planes_)) planes->next(*this, meshes.vertices);
    ++made_;
    ++mesh.sheets;
    points += 2 * plane;
  } while (!done() && meshes.vertices.size() < budget);
  const SheetVertex* v = &meshes.vertices[mesh.first];
  mesh.left = mesh.right = v->x;
  mesh.top = mesh.bottom = v->y;
  for (; v != meshes.vertices.data() + meshes.vertices.size(); ++v) {
    mesh.left = std::min(mesh.left, v->x);
    mesh.right = std::max(mesh.right, v->x);
    mesh.top = std::min(mesh.top, v->y);
    mesh.bottom = std::max(mesh.bottom, v->y);
  }
  meshes.meshes.push_back(mesh);
  return points;
}

}  // namespace vol::curvilinear
