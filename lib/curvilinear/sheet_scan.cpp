// Sheets as triangles between points of forward differences, with the length of the rays inside.
#include <algorithm>

#include "curvilinear/forward_difference.h"
#include "curvilinear/sheet_parts.h"

namespace vol::curvilinear {
namespace {

/// A point of a sheet: in view coordinates and in the picture, with the way across the sheet.
struct Vertex {
  Vec3 view, across;  ///< across: from the sheet's front face to its back face, along w
  Eigen::Vector2d image;
  float value;
};

/// Where the edge between two image positions crosses a row's centre. From the upper end, whoever asks: both
/// triangles of an edge get the same bits.
double crossing(const Eigen::Vector2d& p, const Eigen::Vector2d& q, double y) {
  const bool down = p.y() < q.y() || (p.y() == q.y() && p.x() < q.x());
  const Eigen::Vector2d &a = down ? p : q, &b = down ? q : p;
  return a.x() + (y - a.y()) * ((b.x() - a.x()) / (b.y() - a.y()));
}

/// A quantity linear over a triangle in the picture, held within its corners' values.
struct Linear {
  double at0, dx, dy, low, high;
  Linear(const Vertex& a, const Vertex& b, const Vertex& c, double area, double fa, double fb, double fc)
      : low(std::min({fa, fb, fc})), high(std::max({fa, fb, fc})) {
    const Eigen::Vector2d ab = b.image - a.image, ac = c.image - a.image;
    dx = ((fb - fa) * ac.y() - (fc - fa) * ab.y()) / area;
    dy = ((fc - fa) * ab.x() - (fb - fa) * ac.x()) / area;
    at0 = fa - dx * a.image.x() - dy * a.image.y();
  }
  [[nodiscard]] double operator()(double x, double y) const {
    return std::clamp(at0 + dx * x + dy * y, low, high);
  }
};

template <class T>
class Scan {
 public:
  Scan(const Solid& solid, const Screen& screen, const TransferTable& table, const Lattice& lattice,
       double depth_scale, Band& band)
      : screen_(screen),
        table_(table),
        band_(band),
        lattice_(lattice),
        depth_scale_(depth_scale),
        origin_(solid(Vec3(0.5, 0.5, 0.5))),
        longest_(solid.hull().size().norm()),
        f_(solid, origin_, lattice) {}

  /// The planes of the lattice are in turn faces and middles of the sheets.
  void draw() {
    const int sheets = lattice_.steps[2] / 2;
    read(front_);
    for (int w = 0; w < sheets; ++w) {
      f_.next_plane();
      read(middle_);
      f_.next_plane();
      read(back_);
      draw_sheet();
      front_.swap(back_);
    }
    band_.counts.sheets += sheets;
  }

 private:
  const Screen& screen_;
  const TransferTable& table_;
  Band& band_;
  Lattice lattice_;
  double depth_scale_;
  Point4 origin_;
  double longest_;
  ForwardDifferences<T> f_;
  std::vector<Eigen::Array<T, 4, 1>> front_, middle_, back_;
  std::vector<Vertex> vertices_;

  void read(std::vector<Eigen::Array<T, 4, 1>>& points) {
    points.clear();
    f_.each_row([&](int, Differences<T>& row) {
      for (int u = 0; u < lattice_.counts[0]; ++u, row.advance()) points.push_back(row.value());
    });
    band_.counts.points += static_cast<std::int64_t>(points.size());
  }
  void draw_sheet() {
    vertices_.clear();
    for (std::size_t n = 0; n < middle_.size(); ++n) {
      const Point4 p = middle_[n].matrix().template cast<double>() + origin_;
      const Vec3 across = (back_[n] - front_[n]).matrix().template cast<double>().template head<3>();
      vertices_.push_back({p.head<3>(), across, screen_.project(p.head<3>()), static_cast<float>(p[3])});
    }
    const auto row = static_cast<std::size_t>(lattice_.counts[0]);
    for (std::size_t v = 0; v + 1 < static_cast<std::size_t>(lattice_.counts[1]); ++v) {
      for (std::size_t u = 0; u + 1 < row; ++u) {
        const Vertex* a = &vertices_[u + row * v];
        draw_triangle(a[0], a[1], a[row]);
        draw_triangle(a[1], a[row], a[row + 1]);
      }
    }
  }
  void draw_triangle(const Vertex& a, const Vertex& b, const Vertex& c) {
    const double top = std::min({a.image.y(), b.image.y(), c.image.y()}),
                 bottom = std::max({a.image.y(), b.image.y(), c.image.y()});
    const int first = static_cast<int>(std::ceil(std::max(top - 0.5, static_cast<double>(band_.top)))),
              end = static_cast<int>(std::ceil(std::min(bottom - 0.5, static_cast<double>(band_.bottom))));
    if (first >= end) return;
    const Eigen::Vector2d ab = b.image - a.image, ac = c.image - a.image;
    const double area = ab.x() * ac.y() - ab.y() * ac.x();
    if (area == 0) return;
    const Vec3 normal = (b.view - a.view).cross(c.view - a.view);
    // Light crosses the slab of normal N and way across s by |s N| / |d N|, and no solid by more than its
    // size.
    const auto length = [&](const Vertex& v) {
      const double l = std::abs(v.across.dot(normal) / screen_.direction(v.view).dot(normal));
      return l < longest_ ? l : longest_;
    };
    const Linear value(a, b, c, area, static_cast<double>(a.value), static_cast<double>(b.value),
                       static_cast<double>(c.value));
    const Linear depth(a, b, c, area, length(a), length(b), length(c));
    for (int y = first; y < end; ++y) {
      const double row = y + 0.5;
      double left = std::numeric_limits<double>::infinity(), right = -left;
      const auto cross = [&](const Vertex& p, const Vertex& q) {
        // Half open: a corner on the row's centre belongs to the edge below it.
        if ((p.image.y() <= row) == (q.image.y() <= row)) return;
        const double x = crossing(p.image, q.image, row);
        left = std::min(left, x);
        right = std::max(right, x);
      };
      cross(a, b);
      cross(b, c);
      cross(c, a);
      if (!(left < right)) continue;
      const int from = static_cast<int>(std::ceil(std::max(left - 0.5, 0.0))),
                to = static_cast<int>(std::ceil(std::min(right - 0.5, static_cast<double>(band_.width))));
      for (int x = from; x < to; ++x) {
        const double share = depth(x + 0.5, row) * depth_scale_;
        if (share > 0) {
          band_.composite(band_.at(x, y), table_(static_cast<float>(value(x + 0.5, row))),
                          static_cast<float>(share));
        }
      }
    }
  }
};

/// Pieces along u and v by which chords miss the solid by at most a twentieth of a pixel, and values by the
/// tolerance: h^2 / 8 of the second derivative along an axis (at most 6 times the largest second difference
/// of control points), h^2 / 4 of the mixed one (9 times the mixed difference) across a piece cut in two.
std::array<int, 2> flat_pieces(const Solid& solid, const Screen& screen, double value_tolerance) {
  constexpr double kPixels = 0.05;
  const double unit = kPixels / screen.pixels(solid(Vec3(0.5, 0.5, 0.5)).head<3>());
  const auto measure = [&](const Point4& d) {
    return std::max(d.head<3>().norm() / unit, value_tolerance > 0 ? std::abs(d[3]) / value_tolerance : 0);
  };
  double bend[2] = {}, twist = 0;
  constexpr std::size_t kStride[2] = {1, 4};
  for (std::size_t n = 0; n < 64; ++n) {
    const std::size_t at[2] = {n % 4, n / 4 % 4};
    for (std::size_t a = 0; a < 2; ++a) {
      const std::size_t s = kStride[a];
      if (at[a] < 2)
        bend[a] = std::max(bend[a], 6 * measure(solid.b[n] - 2 * solid.b[n + s] + solid.b[n + 2 * s]));
    }
    if (at[0] < 3 && at[1] < 3) {
      twist = std::max(twist, 9 * measure(solid.b[n] - solid.b[n + 1] - solid.b[n + 4] + solid.b[n + 5]));
    }
  }
  // The sum of the three errors within 1: half for the bends, half for the twist.
  double pieces[2];
  for (int a = 0; a < 2; ++a) pieces[a] = std::max(1.0, std::sqrt(bend[a] / 2));
  const double mixed = twist / 4 / (pieces[0] * pieces[1]);
  if (mixed > 0.5) {
    for (double& n : pieces) n *= std::sqrt(2 * mixed);
  }
  const Extents e = extents(solid, screen);
  std::array<int, 2> counts{};
  for (std::size_t a = 0; a < 2; ++a) {
    // Pieces of less than a pixel show no more.
    const double n = std::min(std::max(pieces[a], e.across[a] / screen.linear_pixels()), e.across[a]);
    counts[a] = step_count(n, 1);
  }
  return counts;
}

}  // namespace

void draw_scanned(const Solid& solid, const Screen& screen, const TransferTable& table, double throttle,
                  double depth_scale, double value_tolerance, Band& band) {
  const std::array<int, 2> pieces = flat_pieces(solid, screen, value_tolerance);
  const int sheets = std::min(kMostSteps / 2, step_count(extents(solid, screen).length[2], throttle));
  const Lattice lattice{
      {pieces[0], pieces[1], 2 * sheets}, {pieces[0] + 1, pieces[1] + 1, 2 * sheets + 1}, Vec3::Zero()};
  if (std::max({pieces[0], pieces[1], 2 * sheets}) <= kFloatSteps) {
    Scan<float>(solid, screen, table, lattice, depth_scale, band).draw();
  } else {
    Scan<double>(solid, screen, table, lattice, depth_scale, band).draw();
  }
}

}  // namespace vol::curvilinear
