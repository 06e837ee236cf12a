#include "curvilinear/sheets.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "base/parallel.h"
#include "curvilinear/halves.h"
#include "curvilinear/sheet_parts.h"

namespace vol::curvilinear {
namespace {

Dims at(std::int64_t number, const Dims& cells) {
  return {number % cells[0], number / cells[0] % cells[1], number / (cells[0] * cells[1])};
}

/// Whether the parameter along an axis grows (1) or falls (-1) along the ray through the middle of the
/// solid's section at `u` of it; 0: neither.
int runs_away(const Solid& seen, int axis, double u, const Screen& screen) {
  Eigen::Matrix<double, 4, 3> d;
  Vec3 at(0.5, 0.5, 0.5);
  at[axis] = u;
  const Vec3 ray = screen.direction(seen(at, d).head<3>());
  const double area = d.col((axis + 1) % 3).head<3>().cross(d.col((axis + 2) % 3).head<3>()).dot(ray);
  const double forward = d.topRows<3>().determinant() < 0 ? -area : area;
  return forward > 0 ? 1 : forward < 0 ? -1 : 0;
}

class Sheets {
 public:
  Sheets(const Grid& grid, const std::vector<std::vector<double>>& values, const camera::Camera& camera,
         const transfer::TransferFunction& transfer, double reference_length, const SheetOptions& options)
      : camera_(camera),
        options_(options),
        screen_(camera),
        table_(transfer, options.thinned_by),
        depth_scale_(screen_.world_length() / reference_length) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
      solids_.emplace_back(grid.blocks[b], values[b], options.cells, options.beta);
      for (const double f : values[b]) {
        low = std::min(low, f);
        high = std::max(high, f);
      }
    }
    value_tolerance_ = 1e-3 * (high - low);
    for (std::size_t b = 0; b < solids_.size(); ++b) list(static_cast<std::uint32_t>(b));
    std::vector<Dims> block_cells;
    for (const Block& block : grid.blocks) block_cells.push_back(block.cells());
    circles_ = put_in_order(cells_, block_cells, options.order);
  }

  [[nodiscard]] SheetResult draw() const {
    SheetResult result{
        image::Image(camera_.image_width(), camera_.image_height(), {"R", "G", "B", "A", "samples"}), {}};
    // A pixel's samples come in the order of the cells, whatever the bands and the threads.
    constexpr std::int64_t kRows = 32;
    result.counts = parallel_reduce<SheetCounts>(
        0, camera_.image_height(), kRows,
        [&](std::int64_t top, std::int64_t bottom) {
          Band band(camera_.image_width(), static_cast<int>(top), static_cast<int>(bottom));
          draw(band);
          store(band, result.image);
          return band.counts;
        },
        [](SheetCounts& sum, const SheetCounts& part) {
          sum.sheets += part.sheets;
          sum.points += part.points;
          sum.samples += part.samples;
          sum.redundant += part.redundant;
        });
    result.counts.cells = static_cast<std::int64_t>(cells_.size());
    result.counts.circles = circles_;
    result.counts.holes = holes(result.image);
    return result;
  }

 private:
  const camera::Camera& camera_;
  const SheetOptions& options_;
  Screen screen_;
  TransferTable table_;
  double depth_scale_, value_tolerance_ = 0;
  std::vector<Solids> solids_;
  std::vector<VisibleCell> cells_;
  std::int64_t circles_ = 0;

  /// The cells of a block that meet the picture.
  void list(std::uint32_t b) {
    const Block& block = solids_[b].block();
    std::vector<VisibleCell> all(static_cast<std::size_t>(block.cell_count()));
    constexpr std::int64_t kGrain = 512;
    parallel_for(0, block.cell_count(), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t n = begin; n < end; ++n) all[static_cast<std::size_t>(n)] = examined(b, n);
    });
    for (const VisibleCell& cell : all) {
      if (cell.top < cell.bottom) cells_.push_back(cell);
    }
  }
  [[nodiscard]] VisibleCell examined(std::uint32_t b, std::int64_t number) const {
    const Block& block = solids_[b].block();
    VisibleCell cell{std::numeric_limits<double>::infinity(), b, number, 0, 0, {}};
    const Dims place = at(number, block.cells());
    if (block.is_missing(place)) return cell;
    const Solid seen = screen_.view(solids_[b](place));
    double top = std::numeric_limits<double>::infinity(), bottom = -top, left = top, right = -top;
    for (std::size_t n = 0; n < 64; ++n) {
      const Vec3 p = seen.b[n].head<3>();
      if (!screen_.in_front(p)) {
        throw Error(
            "the eye of the perspective view is within the grid or has cells behind it; take a greater "
            "distance");
      }
      const Eigen::Vector2d image = screen_.project(p);
      top = std::min(top, image.y());
      bottom = std::max(bottom, image.y());
      left = std::min(left, image.x());
      right = std::max(right, image.x());
      if (n % 4 % 3 == 0 && n / 4 % 4 % 3 == 0 && n / 16 % 3 == 0) cell.depth = std::min(cell.depth, p.z());
    }
    if (!(right >= 0 && left <= camera_.image_width())) return cell;
    for (int a = 0; a < 3 && options_.order == CellOrder::faces; ++a) {
      cell.before_next[static_cast<std::size_t>(a)] =
          static_cast<std::int8_t>(runs_away(seen, a, 1, screen_));
    }
    const double height = camera_.image_height();
    cell.top = static_cast<int>(std::floor(std::clamp(top, 0.0, height)));
    cell.bottom = static_cast<int>(std::min(std::floor(std::clamp(bottom, -1.0, height)) + 1, height));
    return cell;
  }

  void draw(Band& band) const {
    for (const VisibleCell& cell : cells_) {
      if (cell.bottom <= band.top || cell.top >= band.bottom) continue;
      const Solids& solids = solids_[cell.block];
      draw(screen_.view(solids(at(cell.number, solids.block().cells()))), kMostHalvings, band);
    }
  }
  static constexpr int kMostHalvings = 6;
  void draw(const Solid& seen, int halvings, Band& band) const {
    const Solid solid = oriented(seen, screen_);
    if (options_.thickness == Thickness::layers) {
      draw_layers(solid, screen_, table_, options_.throttle, band);
      return;
    }
    const int axis = halvings > 0 ? axis_to_halve(solid, screen_) : -1;
    if (axis < 0) {
      draw_scanned(solid, screen_, table_, options_.throttle, depth_scale_, value_tolerance_, band);
      return;
    }
    const std::array<Solid, 2> parts = halves(solid, static_cast<std::size_t>(axis));
    const std::size_t front = runs_away(solid, axis, 0.5, screen_) >= 0 ? 0 : 1;
    draw(parts[front], halvings - 1, band);
    draw(parts[1 - front], halvings - 1, band);
  }
  static void store(Band& band, image::Image& image) {
    for (int y = band.top; y < band.bottom; ++y) {
      for (int x = 0; x < band.width; ++x) {
        const Band::Pixel& pixel = band.at(x, y);
        const float channels[5] = {pixel.r, pixel.g, pixel.b, 1 - pixel.transmittance,
                                   static_cast<float>(pixel.samples)};
        for (int c = 0; c < 5; ++c) image.at(x, y, c) = channels[c];
      }
    }
  }
  static std::int64_t holes(const image::Image& image) {
    const auto met = [&](int x, int y) {
      return x >= 0 && x < image.width && y >= 0 && y < image.height && image.at(x, y, 4) > 0;
    };
    std::int64_t count = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        count += !met(x, y) && ((met(x - 1, y) && met(x + 1, y)) || (met(x, y - 1) && met(x, y + 1)));
      }
    }
    return count;
  }
};

}  // namespace

double global_layers(const Grid& grid, double gamma) {
  std::int64_t m = std::numeric_limits<std::int64_t>::max();
  for (const Block& block : grid.blocks) {
    for (const std::int64_t cells : block.cells()) m = std::min(m, cells);
  }
  return gamma * std::max(1.0, std::log(static_cast<double>(m)));
}

SheetResult draw_sheets(const Grid& grid, const std::vector<std::vector<double>>& values,
                        const camera::Camera& camera, const transfer::TransferFunction& transfer,
                        double reference_length, const SheetOptions& options) {
  if (!(options.throttle > 0 && std::isfinite(options.throttle)))
    throw Error("the throttle must be positive and finite");
  return Sheets(grid, values, camera, transfer, reference_length, options).draw();
}

}  // namespace vol::curvilinear
