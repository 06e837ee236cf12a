#include "curvilinear/gaps.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "curvilinear/cubic_basis.h"

namespace vol::curvilinear {
namespace {

constexpr double kPixels = 0.1;  ///< by which triangles may miss a face, and depths may be told apart
constexpr int kRows = 32;
constexpr std::size_t kStride[3] = {1, 4, 16};

/// A face of a cell as a grid of points: depth and parameters across the picture.
struct OpenFace {
  std::uint32_t cell;
  int axis, side, columns, rows;
  Vec3 first;  ///< parameters of the cell's lowest corner
  double size;
  bool right_handed;
  std::vector<Vec3> points;  ///< image position and depth
};

struct Passage {
  int pixel;
  double depth;
  std::uint32_t cell;
  bool leaves;
  Vec3 at;
};

int pieces(double second, double mixed) {
  constexpr double kMost = 64;
  return static_cast<int>(
      std::clamp(std::ceil(std::sqrt((0.75 * second + 2.25 * mixed) / kPixels)), 1.0, kMost));
}

OpenFace open_face(const Solid& solid, std::uint32_t cell, const Vec3& first, double size, int axis, int side,
                   const Screen& screen) {
  const std::size_t u = kStride[(axis + 1) % 3], v = kStride[(axis + 2) % 3];
  Vec3 b[4][4];
  Eigen::Vector2d image[4][4];
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      b[j][i] =
          solid.b[i * u + j * v + (side > 0 ? 3 * kStride[static_cast<std::size_t>(axis)] : 0)].head<3>();
      image[j][i] = screen.project(b[j][i]);
    }
  }
  double along_u = 0, along_v = 0, mixed = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (i < 2) along_u = std::max(along_u, (image[j][i] - 2 * image[j][i + 1] + image[j][i + 2]).norm());
      if (j < 2) along_v = std::max(along_v, (image[j][i] - 2 * image[j + 1][i] + image[j + 2][i]).norm());
      if (i < 3 && j < 3)
        mixed =
            std::max(mixed, (image[j][i] - image[j][i + 1] - image[j + 1][i] + image[j + 1][i + 1]).norm());
    }
  }
  Eigen::Matrix<double, 4, 3> d;
  (void)solid.centre(d);
  OpenFace face{cell,
                axis,
                side,
                pieces(along_u, mixed) + 1,
                pieces(along_v, mixed) + 1,
                first,
                size,
                d.topRows<3>().determinant() >= 0,
                {}};
  for (int row = 0; row < face.rows; ++row) {
    const CubicBasis y(static_cast<double>(row) / (face.rows - 1));
    for (int column = 0; column < face.columns; ++column) {
      const CubicBasis x(static_cast<double>(column) / (face.columns - 1));
      Vec3 p = Vec3::Zero();
      for (std::size_t j = 0; j < 4; ++j) {
        for (std::size_t i = 0; i < 4; ++i) p += y.b[j] * x.b[i] * b[j][i];
      }
      const Eigen::Vector2d at = screen.project(p);
      face.points.emplace_back(at.x(), at.y(), p.z());
    }
  }
  return face;
}

/// Whether a face of a cell, or group of size^3, lies beside some cell that is not listed. One that does so
/// in part is taken for open: what it adds are passages, whose order is that of the ray.
bool is_open(const CellPlaces& place, std::uint32_t block, const Dims& first, std::int64_t size,
             std::size_t axis, int side) {
  Dims beside = first;
  beside[axis] += side > 0 ? size : -1;
  const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (beside[v] = first[v]; beside[v] < first[v] + size; ++beside[v]) {
    for (beside[u] = first[u]; beside[u] < first[u] + size; ++beside[u]) {
      if (place(block, beside) < 0) return true;
    }
  }
  return false;
}

/// The faces beside which no other cell is listed.
std::vector<OpenFace> open_faces(const std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells,
                                 const SolidOf& solid_of, const Screen& screen) {
  const CellPlaces place(cells, block_cells);
  std::vector<OpenFace> faces;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const Dims first = first_cell(cells[c], block_cells);
    const std::int64_t size = std::int64_t{1} << cells[c].level;
    Solid solid;
    bool made = false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        if (!is_open(place, cells[c].block, first, size, static_cast<std::size_t>(axis), side)) continue;
        if (!made) solid = solid_of(cells[c]);
        made = true;
        const Vec3 corner(static_cast<double>(first[0]), static_cast<double>(first[1]),
                          static_cast<double>(first[2]));
        faces.push_back(open_face(solid, static_cast<std::uint32_t>(c), corner, static_cast<double>(size),
                                  axis, side, screen));
      }
    }
  }
  return faces;
}

/// Rays through the pixels' centres of rows [top, bottom) that pass a triangle of a face; a, b and c as
/// (column, row) of its points.
class Passages {
 public:
  Passages(int width, int top, int bottom) : width_(width), top_(top), bottom_(bottom) {}
  std::vector<Passage> all;

  void add(const OpenFace& face) {
    for (int row = 0; row + 1 < face.rows; ++row) {
      for (int column = 0; column + 1 < face.columns; ++column) {
        triangle(face, {column, row}, {column + 1, row}, {column, row + 1});
        triangle(face, {column + 1, row + 1}, {column, row + 1}, {column + 1, row});
      }
    }
  }

 private:
  int width_, top_, bottom_;
  using Place = std::array<int, 2>;

  void triangle(const OpenFace& face, const Place& a, const Place& b, const Place& c) {
    const auto point = [&](const Place& at) {
      return face.points[static_cast<std::size_t>(at[0] + at[1] * face.columns)];
    };
    const Vec3 p = point(a), q = point(b), r = point(c);
    const double area = (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
    if (area == 0) return;
    // The face's parameters turn with the picture where its normal points away from the eye.
    const bool away = (area > 0) == face.right_handed;
    const bool leaves = away == (face.side > 0);
    const auto centre = [](double x, int low, int high) {
      return static_cast<int>(
          std::ceil(std::clamp(x - 0.5, static_cast<double>(low), static_cast<double>(high))));
    };
    const int top = centre(std::min({p.y(), q.y(), r.y()}), top_, bottom_),
              bottom = centre(std::max({p.y(), q.y(), r.y()}), top_, bottom_),
              left = centre(std::min({p.x(), q.x(), r.x()}), 0, width_),
              right = centre(std::max({p.x(), q.x(), r.x()}), 0, width_);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double s = ((px - p.x()) * (r.y() - p.y()) - (py - p.y()) * (r.x() - p.x())) / area;
        const double t = ((q.x() - p.x()) * (py - p.y()) - (q.y() - p.y()) * (px - p.x())) / area;
        if (!(s >= 0 && t >= 0 && s + t <= 1)) continue;
        Vec3 at;
        at[face.axis] = face.side;
        at[(face.axis + 1) % 3] = mixed(a[0], b[0], c[0], s, t) / (face.columns - 1);
        at[(face.axis + 2) % 3] = mixed(a[1], b[1], c[1], s, t) / (face.rows - 1);
        all.push_back({x + width_ * y, mixed(p.z(), q.z(), r.z(), s, t), face.cell, leaves,
                       face.first + face.size * at});
      }
    }
  }
  static double mixed(double p, double q, double r, double s, double t) {
    return p + s * (q - p) + t * (r - p);
  }
};

std::vector<GapCrossing> crossings(std::vector<Passage>& passages, const Screen& screen) {
  for (Passage& p : passages) {
    if (p.leaves) p.depth -= kPixels / screen.pixels(Vec3(0, 0, p.depth));
  }
  std::sort(passages.begin(), passages.end(), [](const Passage& a, const Passage& b) {
    if (a.pixel != b.pixel) return a.pixel < b.pixel;
    if (a.depth != b.depth) return a.depth < b.depth;
    return a.leaves != b.leaves ? a.leaves : a.cell < b.cell;
  });
  std::vector<GapCrossing> found;
  const Passage* left = nullptr;
  for (const Passage& p : passages) {
    if (left != nullptr && left->pixel != p.pixel) left = nullptr;
    if (p.leaves) {
      left = &p;
    } else if (left != nullptr && left->cell != p.cell) {
      found.push_back({left->cell, p.cell, left->at, p.at});
    }
  }
  return found;
}

}  // namespace

std::vector<GapCrossing> gap_crossings(const std::vector<VisibleCell>& cells,
                                       const std::vector<Dims>& block_cells, const SolidOf& solid_of,
                                       const Screen& screen, int width, int height) {
  const std::vector<OpenFace> faces = open_faces(cells, block_cells, solid_of, screen);
  std::vector<std::vector<GapCrossing>> bands(static_cast<std::size_t>((height + kRows - 1) / kRows));
  parallel_for(0, static_cast<std::int64_t>(bands.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t n = begin; n < end; ++n) {
      const int top = kRows * static_cast<int>(n), bottom = std::min(top + kRows, height);
      Passages passages(width, top, bottom);
      for (const OpenFace& face : faces) {
        const VisibleCell& cell = cells[face.cell];
        if (cell.bottom > top && cell.top < bottom) passages.add(face);
      }
      bands[static_cast<std::size_t>(n)] = crossings(passages.all, screen);
    }
  });
  std::vector<GapCrossing> all;
  for (const auto& band : bands) all.insert(all.end(), band.begin(), band.end());
  std::stable_sort(all.begin(), all.end(), [](const GapCrossing& a, const GapCrossing& b) {
    return a.front != b.front ? a.front < b.front : a.back < b.back;
  });
  return all;
}

}  // namespace vol::curvilinear
