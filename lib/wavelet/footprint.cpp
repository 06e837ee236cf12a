#include "wavelet/footprint.h"

#include <algorithm>
#include <cmath>

#include "wavelet/footprint_kernel.h"

namespace vol::wavelet {
namespace {

/// Values of X + alpha u, u in [begin, end], that meet the support of f.
struct Range {
  double lower, upper;
};
Range range_of(const PiecewiseCubic& f, double slope, double begin, double end) {
  return {f.lower - std::max(slope * begin, slope * end), f.upper() - std::min(slope * begin, slope * end)};
}

/// Width of the cells along z that get two Gauss nodes each.
double cell_width(const PiecewiseCubic& z, double h) {
  double width = z.spacing;
  while (width > 2 * h) width /= 2;
  while (2 * width <= h) width *= 2;
  return width;
}

struct Nodes {
  std::vector<double> u, weight;      ///< weight: that of the quadrature times z(u)
  std::vector<std::int64_t> segment;  ///< first node of each segment between limits, and their number
};

/// Cells on multiples of their width from z.lower, cut at the limits.
Nodes make_nodes(const PiecewiseCubic& z, std::span<const double> limits, bool below, double h) {
  std::vector<double> ends(limits.begin(), limits.end());
  if (below) {
    ends.insert(ends.begin(), z.lower);
  } else {
    ends.push_back(z.upper());
  }
  const double width = cell_width(z, h);
  const double node = 0.5 / std::sqrt(3.0);
  Nodes nodes;
  nodes.segment.push_back(0);
  for (std::size_t s = 0; s + 1 < ends.size(); ++s) {
    double at = ends[s];
    while (at < ends[s + 1]) {
      const double next = z.lower + width * (std::floor((at - z.lower) / width + 1e-9) + 1);
      const double to = std::min(next, ends[s + 1]);
      for (const double side : {-node, node}) {
        const double u = 0.5 * (at + to) + side * (to - at);
        nodes.u.push_back(u);
        nodes.weight.push_back(0.5 * (to - at) * z.value(u));
      }
      at = to;
    }
    nodes.segment.push_back(static_cast<std::int64_t>(nodes.u.size()));
  }
  return nodes;
}

std::int64_t up_to_multiple(std::int64_t n, std::int64_t of) {
  return (n + of - 1) / of * of;
}

constexpr std::int64_t kMargin = 2;  // samples beyond the support, so that stencils need no clamping

struct Grid {
  double x0, y0;
  std::int64_t nx, ny;
};
Grid grid_of(const FootprintLines& lines, double begin, double end, double h) {
  const Range x = range_of(*lines.x, lines.alpha, begin, end), y = range_of(*lines.y, lines.beta, begin, end);
  // On multiples of h: at a view along an axis the knots, multiples of a power of two, are then samples.
  const double i0 = std::floor(x.lower / h) - kMargin, j0 = std::floor(y.lower / h) - kMargin;
  const double i1 = std::ceil(x.upper / h) + kMargin, j1 = std::ceil(y.upper / h) + kMargin;
  return {i0 * h, j0 * h, static_cast<std::int64_t>(i1 - i0) + 1, static_cast<std::int64_t>(j1 - j0) + 1};
}

struct Span {
  std::int64_t begin, end;
};
/// Nodes at which X + slope u lies in the support of f for an X in [low, high].
Span nodes_meeting(const std::vector<double>& u, const PiecewiseCubic& f, double slope, double low,
                   double high) {
  if (slope == 0) {
    const bool meets = high > f.lower && low < f.upper();
    return {0, meets ? static_cast<std::int64_t>(u.size()) : 0};
  }
  double from = (f.lower - high) / slope, to = (f.upper() - low) / slope;
  if (slope < 0) {
    from = (f.upper() - low) / slope;
    to = (f.lower - high) / slope;
  }
  return {std::lower_bound(u.begin(), u.end(), from) - u.begin(),
          std::upper_bound(u.begin(), u.end(), to) - u.begin()};
}

/// The part of the sums that a table's own limit can reach.
FootprintTable cut_out(const std::vector<double>& sum, std::int64_t stride, const Grid& all, const Grid& own,
                       double h) {
  FootprintTable table{own.x0, own.y0, h, own.nx, own.ny, {}};
  const auto i0 = static_cast<std::int64_t>(std::llround((own.x0 - all.x0) / h));
  const auto j0 = static_cast<std::int64_t>(std::llround((own.y0 - all.y0) / h));
  table.values.resize(static_cast<std::size_t>(own.nx * own.ny));
  for (std::int64_t i = 0; i < own.nx; ++i) {
    const double* row = sum.data() + (i + i0) * stride + j0;
    float* out = table.values.data() + i * own.ny;
    for (std::int64_t j = 0; j < own.ny; ++j) out[j] = static_cast<float>(row[j]);
  }
  return table;
}

}  // namespace

std::array<double, 4> cubic_weights(double v) {
  return {-v * (v - 1) * (v - 2) / 6, (v + 1) * (v - 1) * (v - 2) / 2, -(v + 1) * v * (v - 2) / 2,
          (v + 1) * v * (v - 1) / 6};
}

double FootprintTable::value(double x, double y) const {
  const double p = (x - x0) / h, q = (y - y0) / h;
  if (!(p >= 1 && q >= 1 && p < static_cast<double>(nx - 2) && q < static_cast<double>(ny - 2))) return 0;
  const auto i = static_cast<std::int64_t>(p), j = static_cast<std::int64_t>(q);
  const auto wx = cubic_weights(p - static_cast<double>(i)), wy = cubic_weights(q - static_cast<double>(j));
  double sum = 0;
  for (std::int64_t a = 0; a < 4; ++a) {
    const float* row = values.data() + (i - 1 + a) * ny + (j - 1);
    sum +=
        wx[static_cast<std::size_t>(a)] * (wy[0] * row[0] + wy[1] * row[1] + wy[2] * row[2] + wy[3] * row[3]);
  }
  return sum;
}

FootprintCost footprint_cost(const FootprintLines& lines, std::span<const double> limits, bool below,
                             double h) {
  const double begin = below ? lines.z->lower : limits.front(),
               end = below ? limits.back() : lines.z->upper();
  const Range x = range_of(*lines.x, lines.alpha, begin, end), y = range_of(*lines.y, lines.beta, begin, end);
  const double nx = (x.upper - x.lower) / h + 2 * kMargin + 2, ny = (y.upper - y.lower) / h + 2 * kMargin + 2;
  const double nodes = 2 * ((end - begin) / cell_width(*lines.z, h) + static_cast<double>(limits.size()));
  // Of each row and column only the nodes count at which its factor does not vanish.
  const double share = (lines.x->upper() - lines.x->lower) / (x.upper - x.lower) *
                       ((lines.y->upper() - lines.y->lower) / (y.upper - y.lower));
  return {nx * ny * nodes * share,
          static_cast<std::int64_t>(nx * ny * static_cast<double>(limits.size() * sizeof(float)))};
}

std::vector<FootprintTable> make_footprints(const FootprintLines& lines, std::span<const double> limits,
                                            bool below, double h) {
  const double first = below ? lines.z->lower : limits.front();
  const double last = below ? limits.back() : lines.z->upper();
  const Nodes nodes = make_nodes(*lines.z, limits, below, h);
  const auto count = static_cast<std::int64_t>(nodes.u.size());
  const Grid all = grid_of(lines, first, last, h);
  const std::int64_t nx = up_to_multiple(all.nx, kFootprintRows),
                     ny = up_to_multiple(all.ny, kFootprintColumns);

  // y(Y + beta u) by tiles of columns: [tile][node][column].
  std::vector<double> b(static_cast<std::size_t>(ny * count), 0.0);
  std::vector<Span> columns;
  for (std::int64_t tile = 0; tile < ny / kFootprintColumns; ++tile) {
    const double low = all.y0 + h * static_cast<double>(tile * kFootprintColumns);
    const Span span = nodes_meeting(nodes.u, *lines.y, lines.beta, low, low + h * (kFootprintColumns - 1));
    columns.push_back(span);
    double* out = b.data() + tile * kFootprintColumns * count;
    for (std::int64_t n = span.begin; n < span.end; ++n) {
      const double at = low + lines.beta * nodes.u[static_cast<std::size_t>(n)];
      for (std::int64_t c = 0; c < kFootprintColumns; ++c) {
        out[n * kFootprintColumns + c] = lines.y->value(at + h * static_cast<double>(c));
      }
    }
  }

  // Segment by segment from the limit-free end on, so that each table is the one before and what lies
  // between.
  std::vector<double> sum(static_cast<std::size_t>(nx * ny), 0.0);
  std::vector<double> a(static_cast<std::size_t>(kFootprintRows * count));
  std::vector<FootprintTable> tables(limits.size());
  for (std::size_t step = 0; step < limits.size(); ++step) {
    const std::size_t s = below ? step : limits.size() - 1 - step;
    const std::int64_t from = nodes.segment[s], to = nodes.segment[s + 1];
    for (std::int64_t i = 0; i < nx; i += kFootprintRows) {
      const double low = all.x0 + h * static_cast<double>(i);
      Span rows = nodes_meeting(nodes.u, *lines.x, lines.alpha, low, low + h * (kFootprintRows - 1));
      rows = {std::max(rows.begin, from), std::min(rows.end, to)};
      for (std::int64_t n = rows.begin; n < rows.end; ++n) {
        const auto at = static_cast<std::size_t>(n);
        const double x = low + lines.alpha * nodes.u[at];
        for (std::int64_t r = 0; r < kFootprintRows; ++r) {
          a[static_cast<std::size_t>(n * kFootprintRows + r)] =
              nodes.weight[at] * lines.x->value(x + h * static_cast<double>(r));
        }
      }
      for (std::int64_t tile = 0; tile < ny / kFootprintColumns; ++tile) {
        const Span& span = columns[static_cast<std::size_t>(tile)];
        const std::int64_t begin = std::max(rows.begin, span.begin), end = std::min(rows.end, span.end);
        if (begin >= end) continue;
        add_product(a.data(), b.data() + tile * kFootprintColumns * count, begin, end,
                    sum.data() + i * ny + tile * kFootprintColumns, ny);
      }
    }
    const Grid own =
        below ? grid_of(lines, lines.z->lower, limits[s], h) : grid_of(lines, limits[s], lines.z->upper(), h);
    tables[s] = cut_out(sum, ny, all, own, h);
  }
  return tables;
}

bool continuous(const PiecewiseCubic& f) {
  double largest = 0, jump = 0, before = 0;
  for (const auto& a : f.pieces) {
    largest = std::max(largest, std::abs(a[0]));
    jump = std::max(jump, std::abs(a[0] - before));
    before = a[0] + a[1] + a[2] + a[3];
  }
  return std::max(jump, std::abs(before)) <= 1e-9 * largest;
}

double integral(const PiecewiseCubic& f, double a, double b) {
  const double p = std::max((a - f.lower) / f.spacing, 0.0);
  const double q = std::min((b - f.lower) / f.spacing, static_cast<double>(f.pieces.size()));
  double sum = 0;
  for (auto i = static_cast<std::size_t>(p); static_cast<double>(i) < q; ++i) {
    const auto& c = f.pieces[i];
    const auto until = [&c](double v) { return v * (c[0] + v * (c[1] / 2 + v * (c[2] / 3 + v * c[3] / 4))); };
    const double at = static_cast<double>(i);
    sum += until(std::min(q - at, 1.0)) - until(std::max(p - at, 0.0));
  }
  return f.spacing * sum;
}

}  // namespace vol::wavelet
