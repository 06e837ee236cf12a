#include "render/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vol::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::uint8_t one_more(std::uint8_t distance) {
  return distance == 255 ? distance : static_cast<std::uint8_t>(distance + 1);
}

/// Chebyshev distance: two sweeps in opposite order, each taking one more than the least of the 13 neighbours
/// it has passed. Moves of one macrocell in any of the 26 directions cost 1, so the two sweeps are exact.
class DistanceSweeps {
 public:
  explicit DistanceSweeps(Visibility& visibility)
      : v_(visibility), least_(static_cast<std::size_t>(visibility.dims[0]) + 2) {}

  void run() {
    for (std::int64_t c = 0; c < v_.dims[2]; ++c) {
      for (std::int64_t b = 0; b < v_.dims[1]; ++b) sweep_row(b, c, -1);
    }
    for (std::int64_t c = v_.dims[2] - 1; c >= 0; --c) {
      for (std::int64_t b = v_.dims[1] - 1; b >= 0; --b) sweep_row(b, c, 1);
    }
  }

 private:
  std::uint8_t* row(std::int64_t b, std::int64_t c) {
    return v_.distance.data() + v_.dims[0] * (b + v_.dims[1] * c);
  }

  /// `side`: where the rows that were swept before lie.
  void sweep_row(std::int64_t b, std::int64_t c, int side) {
    const std::int64_t n = v_.dims[0];
    std::fill(least_.begin(), least_.end(), std::uint8_t{255});
    const auto take = [&](std::int64_t rb, std::int64_t rc) {
      if (rb < 0 || rb >= v_.dims[1] || rc < 0 || rc >= v_.dims[2]) return;
      const std::uint8_t* other = row(rb, rc);
      for (std::int64_t a = 0; a < n; ++a) {
        auto& least = least_[static_cast<std::size_t>(a) + 1];
        least = std::min(least, other[a]);
      }
    };
    take(b + side, c);
    for (int db = -1; db <= 1; ++db) take(b + db, c + side);
    std::uint8_t* here = row(b, c);
    for (std::int64_t a = 0; a < n; ++a) {
      const std::uint8_t* at = least_.data() + a;
      here[a] = std::min(here[a], one_more(std::min({at[0], at[1], at[2]})));
    }
    const std::int64_t first = side < 0 ? 0 : n - 1;
    for (std::int64_t m = 1; m < n; ++m) {
      const std::int64_t a = first - side * m;
      here[a] = std::min(here[a], one_more(here[a + side]));
    }
  }

  Visibility& v_;
  std::vector<std::uint8_t> least_;
};

/// Distances of one octant, from 0 for visible macrocells and 255 for the others: one more than the least of
/// the 7 neighbours ahead, because a cube of edge D is those of edge D - 1 at them and its own corner. One
/// sweep against the rays.
class OctantSweep {
 public:
  OctantSweep(const Dims& dims, int octant, std::uint8_t* distance)
      : dims_(dims), distance_(distance), least_(static_cast<std::size_t>(dims[0]) + 2) {
    for (int a = 0; a < 3; ++a) ahead_[a] = (octant >> a & 1) != 0 ? -1 : 1;
  }

  void run() {
    for (std::int64_t l = 0; l < dims_[2]; ++l) {
      for (std::int64_t m = 0; m < dims_[1]; ++m) sweep_row(turned(m, 1), turned(l, 2));
    }
  }

 private:
  /// The n-th place of an axis, from where the rays leave it.
  [[nodiscard]] std::int64_t turned(std::int64_t n, int axis) const {
    return ahead_[axis] < 0 ? n : dims_[axis] - 1 - n;
  }

  void sweep_row(std::int64_t b, std::int64_t c) {
    const std::int64_t n = dims_[0];
    const auto row = [&](std::int64_t j, std::int64_t k) { return distance_ + n * (j + dims_[1] * k); };
    std::fill(least_.begin(), least_.end(), std::uint8_t{255});
    const auto take = [&](std::int64_t j, std::int64_t k) {
      if (j < 0 || j >= dims_[1] || k < 0 || k >= dims_[2]) return;
      const std::uint8_t* other = row(j, k);
      for (std::int64_t a = 0; a < n; ++a) {
        auto& least = least_[static_cast<std::size_t>(a) + 1];
        least = std::min(least, other[a]);
      }
    };
    take(b + ahead_[1], c);
    take(b, c + ahead_[2]);
    take(b + ahead_[1], c + ahead_[2]);
    std::uint8_t* here = row(b, c);
    const std::uint8_t* least = least_.data() + 1;
    std::uint8_t next = 255;
    for (std::int64_t m = 0; m < n; ++m) {
      const std::int64_t a = turned(m, 0);
      next = std::min(here[a], one_more(std::min({least[a], least[a + ahead_[0]], next})));
      here[a] = next;
    }
  }

  const Dims dims_;
  std::uint8_t* distance_;
  int ahead_[3];
  std::vector<std::uint8_t> least_;  // of the rows ahead, with one place more at either end
};

}  // namespace

const Buffer<std::uint8_t>& VisibilityAhead::distance(int octant) const {
  Table& table = tables_[static_cast<std::size_t>(octant)];
  std::call_once(table.made, [&] {
    Buffer<std::uint8_t> distance(of_.distance.size());
    std::transform(of_.distance.begin(), of_.distance.end(), distance.begin(),
                   [](std::uint8_t d) { return d > 0 ? std::uint8_t{255} : std::uint8_t{0}; });
    OctantSweep(of_.dims, octant, distance.data()).run();
    table.distance = std::move(distance);
  });
  return table.distance;
}

std::size_t Visibility::offset(const Vec3& u, const Dims& samples) const {
  std::int64_t at[3];
  for (int a = 0; a < 3; ++a) {
    const std::int64_t cells = std::max<std::int64_t>(1, samples[a] - 1);
    const double cell = u[a] * static_cast<double>(cells);
    at[a] = !(cell > 0)
                ? 0
                : std::min(static_cast<std::int64_t>(cell), cells - 1) >> index::Macrocells::kEdgeLog2;
  }
  return static_cast<std::size_t>(at[0] + dims[0] * (at[1] + dims[1] * at[2]));
}

std::vector<volume::Range> invisible_values(const transfer::TransferFunction& transfer) {
  const auto& points = transfer.opacities();
  std::vector<volume::Range> found;
  for (std::size_t i = 0; i < points.size();) {
    if (points[i].opacity > 0) {
      ++i;
      continue;
    }
    std::size_t last = i;
    while (last + 1 < points.size() && points[last + 1].opacity == 0) ++last;
    volume::Range range{points[i].value, points[last].value};
    // At a jump the value itself may take the other side.
    if (i == 0) {
      range.min = -kInfinity;
    } else if (points[i - 1].value == range.min) {
      range.min = std::nextafter(range.min, kInfinity);
    }
    if (last + 1 == points.size()) {
      range.max = kInfinity;
    } else if (points[last + 1].value == range.max) {
      range.max = std::nextafter(range.max, -kInfinity);
    }
    if (range.min <= range.max) found.push_back(range);
    i = last + 1;
  }
  return found;
}

volume::Range widened(const index::Macrocells::Range& range, const index::Macrocells::Range& all) {
  const double lo = range.min, hi = range.max;
  const double magnitude = lo < hi ? std::max(std::abs(lo), std::abs(hi)) : 0;
  const double slack = 1e-6 * std::max(magnitude, hi - double(all.min));
  return {lo - slack, hi + slack};
}

Visibility visibility(const index::Macrocells& cells, const transfer::TransferFunction& transfer) {
  Visibility result;
  result.dims = cells.dims;
  result.distance = Buffer<std::uint8_t>(cells.ranges.size());
  const std::vector<volume::Range> invisible = invisible_values(transfer);
  bool any = false;
  for (std::size_t c = 0; c < cells.ranges.size(); ++c) {
    const volume::Range range = widened(cells.ranges[c], cells.all);
    const bool hidden = std::any_of(invisible.begin(), invisible.end(), [&](const volume::Range& zero) {
      return zero.min <= range.min && range.max <= zero.max;
    });
    result.distance[c] = hidden ? 255 : 0;
    any = any || hidden;
  }
  result.all_visible = !any;
  if (any) DistanceSweeps(result).run();
  return result;
}

}  // namespace vol::render
