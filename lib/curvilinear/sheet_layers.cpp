// The paper's way: points of sheets, each into the pixel it falls into.
#include <algorithm>

#include "curvilinear/forward_difference.h"
#include "curvilinear/sheet_parts.h"

namespace vol::curvilinear {
namespace {

template <class T>
class Layers {
 public:
  Layers(const Solid& solid, const Screen& screen, const TransferTable& table, double throttle, double share,
         Band& band)
      : screen_(screen),
        table_(table),
        band_(band),
        origin_(solid(Vec3(0.5, 0.5, 0.5))),
        lattice_(lattice(solid, screen, throttle)) {
    share_ = static_cast<float>(share / lattice_.steps[2]);
  }
  [[nodiscard]] static Lattice lattice(const Solid& solid, const Screen& screen, double throttle) {
    const Extents e = extents(solid, screen);
    const std::array<int, 3> n = {step_count(e.across[0], throttle), step_count(e.across[1], throttle),
                                  step_count(e.length[2], throttle)};
    return {n, n, Vec3(0.5, 0.5, 0.5)};
  }

  void draw(const Solid& solid) {
    ForwardDifferences<T> f(solid, origin_, lattice_);
    for (int w = 0; w < lattice_.counts[2]; ++w) {
      ++band_.counts.sheets;
      ++band_.sheet;
      f.each_row([&](int, Differences<T>& row) {
        if (meets_band(row)) draw_row(row);
      });
      f.next_plane();
    }
  }

 private:
  const Screen& screen_;
  const TransferTable& table_;
  Band& band_;
  Point4 origin_;
  Lattice lattice_;
  float share_;

  [[nodiscard]] Point4 at(const Eigen::Array<T, 4, 1>& local) const {
    return local.matrix().template cast<double>() + origin_;
  }
  /// By the Bezier points of the row, which is a cubic from its first point on.
  [[nodiscard]] bool meets_band(const Differences<T>& row) const {
    const T n = static_cast<T>(lattice_.steps[0]);
    // Taylor's coefficients over the whole of the row from its differences, then Bezier's.
    const Eigen::Array<T, 4, 1> a3 = row.d[3] * (n * n * n / 6), a2 = (row.d[2] - row.d[3]) * (n * n / 2),
                                a1 = (row.d[1] - row.d[2] / 2 + row.d[3] / 3) * n;
    const Point4 b[4] = {at(row.d[0]), at(row.d[0] + a1 / 3), at(row.d[0] + (2 * a1 + a2) / 3),
                         at(row.d[0] + a1 + a2 + a3)};
    Eigen::Vector2d low = screen_.project(b[0].head<3>()), high = low;
    for (const Point4& p : b) {
      const Eigen::Vector2d image = screen_.project(p.head<3>());
      low = low.cwiseMin(image);
      high = high.cwiseMax(image);
    }
    constexpr double kRounding = 0.01;  // pixels; of float coordinates over a cell that fills the picture
    return high.y() >= band_.top - kRounding && low.y() <= band_.bottom + kRounding &&
           high.x() >= -kRounding && low.x() <= band_.width + kRounding;
  }
  void draw_row(Differences<T>& row) {
    for (int u = 0; u < lattice_.counts[0]; ++u, row.advance()) {
      ++band_.counts.points;
      const Point4 p = at(row.value());
      const Eigen::Vector2d image = screen_.project(p.head<3>());
      if (!(image.x() >= 0 && image.x() < band_.width && image.y() >= band_.top && image.y() < band_.bottom))
        continue;
      const std::size_t pixel = band_.at(static_cast<int>(image.x()), static_cast<int>(image.y()));
      if (band_.sheets[pixel] == band_.sheet) {
        ++band_.counts.redundant;
        continue;
      }
      band_.sheets[pixel] = band_.sheet;
      const TransferTable::Entry& entry = table_(static_cast<float>(p[3]));
      ++band_.counts.samples;
      band_.composite(pixel, entry, opacity_of_depth(entry.depth * share_));
    }
  }
};

}  // namespace

void draw_layers(const Solid& solid, const Screen& screen, const TransferTable& table, double throttle,
                 double share, Band& band) {
  band.sheets.resize(band.pixels.size());
  const Lattice lattice = Layers<float>::lattice(solid, screen, throttle);
  if (*std::max_element(lattice.steps.begin(), lattice.steps.end()) <= kFloatSteps) {
    Layers<float>(solid, screen, table, throttle, share, band).draw(solid);
  } else {
    Layers<double>(solid, screen, table, throttle, share, band).draw(solid);
  }
}

}  // namespace vol::curvilinear
