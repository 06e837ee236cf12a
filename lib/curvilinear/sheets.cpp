#include "curvilinear/sheets.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "curvilinear/circles.h"
#include "curvilinear/halves.h"
#include "curvilinear/larger_error.h"
#include "curvilinear/merged_cells.h"
#include "curvilinear/sheet_mesh.h"

namespace vol::curvilinear {
namespace {

class Sheets {
 public:
  Sheets(const Grid& grid, const std::vector<std::vector<double>>& values, const camera::Camera& camera,
         const transfer::TransferFunction& transfer, double reference_length, const SheetOptions& options)
      : camera_(camera), options_(options), screen_(camera), table_(transfer, options.thinned_by) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Block& block : grid.blocks) blocks_.push_back(screen_.view(block));
    for (const auto& of_block : values) {
      std::vector<double>& shares = shares_.emplace_back();
      shares.reserve(of_block.size());
      for (const double f : of_block) {
        shares.push_back(table_.share(f));
        low = std::min(low, shares.back());
        high = std::max(high, shares.back());
      }
    }
    for (std::size_t b = 0; b < grid.blocks.size(); ++b)
      solids_.emplace_back(blocks_[b], shares_[b], options.cells, options.beta);
    constexpr double kValueShare = 2e-3;
    fineness_ = {options.throttle, kValueShare * options.throttle * std::min(high - low, table_.range()),
                 screen_.world_length() / reference_length};
    tables_.push_back(&table_);
    if (options.sensitivity) {
      // As much again where cells are merged.
      const double off = (options.merge ? 2 : 1) * fineness_.value_tolerance;
      least_.emplace(transfer, options.thinned_by, -off);
      most_.emplace(transfer, options.thinned_by, off);
      tables_.insert(tables_.end(), {&*least_, &*most_});
    }
    if (options.merge) merge();
    for (const Block& block : blocks_) block_cells_.push_back(block.cells());
    for (std::size_t b = 0; b < solids_.size(); ++b) list(static_cast<std::uint32_t>(b));
    put_in_order();
  }

  [[nodiscard]] SheetResult draw() const {
    std::vector<std::string> channels{"R", "G", "B", "A", "samples"};
    if (options_.sensitivity) channels.emplace_back("error");
    SheetResult result{image::Image(camera_.image_width(), camera_.image_height(), channels), {}};
    // A pixel's samples come in the order of the cells, whatever the bands and the threads.
    constexpr int kRows = 32;
    const int height = camera_.image_height();
    std::vector<std::vector<Band>> pictures(tables_.size());
    for (std::vector<Band>& bands : pictures) {
      bands.resize(static_cast<std::size_t>((height + kRows - 1) / kRows));
      each(bands, [&](Band& band) {
        const int top = kRows * static_cast<int>(&band - bands.data());
        band = Band(camera_.image_width(), top, std::min(top + kRows, height));
      });
    }
    std::vector<Band>& bands = pictures.front();
    if (options_.thickness == Thickness::layers) {
      each(bands, [&](Band& band) { draw_cells(band); });
    } else {
      scan(pictures, result.counts);
    }
    each(bands, [&](Band& band) { store(band, result.image); });
    for (std::size_t other = 1; other < pictures.size(); ++other) {
      each(pictures[other], [&](Band& band) { store_difference(band, result.image); });
      for (const Band& band : pictures[other]) result.counts.off_samples += band.counts.samples;
    }
    for (const Band& band : bands) {
      result.counts.sheets += band.counts.sheets;
      result.counts.points += band.counts.points;
      result.counts.samples += band.counts.samples;
      result.counts.redundant += band.counts.redundant;
    }
    result.counts.cells = static_cast<std::int64_t>(cells_.size());
    result.counts.circles = circles_.circles;
    result.counts.split = circles_.split;
    result.counts.unresolved = circles_.unresolved;
    result.counts.holes = holes(result.image);
    return result;
  }

 private:
  const camera::Camera& camera_;
  const SheetOptions& options_;
  Screen screen_;
  TransferTable table_;
  std::optional<TransferTable> least_, most_;
  std::vector<const TransferTable*> tables_;
  SheetFineness fineness_{};
  std::vector<Block> blocks_;                // in view coordinates
  std::vector<std::vector<double>> shares_;  // the values, as the table looks them up
  std::vector<Solids> solids_;
  std::vector<MergedCells> merged_;  // of each block, or none at all
  std::vector<Dims> block_cells_;
  std::vector<VisibleCell> cells_;    // nearest first
  std::vector<CellPart> parts_;       // of cells in circles
  std::vector<std::uint32_t> order_;  // front to back: places of cells, and kPart and places of parts
  static constexpr std::uint32_t kPart = 1U << 31;
  CircleCounts circles_;

  void put_in_order() {
    sort_by_depth(cells_);
    const auto count = static_cast<std::uint32_t>(cells_.size());
    if (options_.order == CellOrder::depth) {
      order_.resize(count);
      std::iota(order_.begin(), order_.end(), 0U);
      return;
    }
    std::vector<Before> before = before_by_faces(cells_, block_cells_);
    const auto solid_of = [this](const VisibleCell& cell) { return solid(cell); };
    std::vector<GapCrossing> gaps;
    if (blocks_.size() > 1 || options_.along_rays) {
      gaps = gap_crossings(cells_, block_cells_, solid_of, screen_, camera_.image_width(),
                           camera_.image_height());
      for (std::size_t n = 0; n < gaps.size(); ++n) {
        const Before here(gaps[n].front, gaps[n].back);
        if (n == 0 || here != Before(gaps[n - 1].front, gaps[n - 1].back)) before.push_back(here);
      }
    }
    FrontToBack found = front_to_back(count, before);
    if (found.circles.empty()) {
      order_ = std::move(found.order);
      return;
    }
    const Circles circles(cells_, block_cells_, solid_of, screen_, gaps);
    auto circle = found.circles.begin();
    for (std::size_t n = 0; n < found.order.size();) {
      if (circle == found.circles.end() || n < circle->begin) {
        order_.push_back(found.order[n++]);
        continue;
      }
      const std::size_t first = parts_.size();
      circles.split({&found.order[circle->begin], circle->end - circle->begin}, parts_, circles_);
      for (std::size_t part = first; part < parts_.size(); ++part)
        order_.push_back(kPart | static_cast<std::uint32_t>(part));
      n = circle->end;
      ++circle;
    }
  }

  /// Position and value by as much as points may miss a solid.
  void merge() {
    constexpr double kPositionShare = 0.1;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      merged_.emplace_back(blocks_[b], shares_[b], options_.cells, options_.beta, [this](const Vec3& at) {
        return MergeTolerance{kPositionShare * options_.throttle / screen_.pixels(at),
                              fineness_.value_tolerance};
      });
    }
  }

  /// The cells of a block that meet the picture.
  void list(std::uint32_t b) {
    const Block& block = blocks_[b];
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
    VisibleCell cell{std::numeric_limits<double>::infinity(), b, number};
    const Dims place = first_cell(cell, block_cells_);
    if (blocks_[b].is_missing(place)) return cell;
    if (!merged_.empty()) {
      const int level = merged_[b].level(place);
      const std::int64_t mask = (std::int64_t{1} << level) - 1;
      if (((place[0] | place[1] | place[2]) & mask) != 0) return cell;  // its group's first stands for it
      cell.level = static_cast<std::uint8_t>(level);
    }
    const Solid seen = solid(cell);
    for (std::size_t n = 0; n < 64 && screen_.is_perspective(); ++n) {
      if (!screen_.in_front(seen.b[n].head<3>())) {
        throw Error(
            "the eye of the perspective view is within the grid or has cells behind it; take a greater "
            "distance");
      }
    }
    for (const std::size_t n : {0, 3, 12, 15, 48, 51, 60, 63})
      cell.depth = std::min(cell.depth, seen.b[n].z());
    const ImageBox box(seen, screen_);
    if (!(box.right >= 0 && box.left <= camera_.image_width())) return cell;
    for (int a = 0; a < 3 && options_.order == CellOrder::faces; ++a) {
      Eigen::Matrix<double, 4, 3> d;
      const Vec3 middle = seen.face_centre(a, d).head<3>();
      cell.before_next[static_cast<std::size_t>(a)] =
          static_cast<std::int8_t>(screen_.runs_away(middle, d, a));
      if (merged_.empty()) continue;
      Vec3 previous(0.5, 0.5, 0.5);
      previous[a] = 0;
      const Vec3 there = seen(previous, d).head<3>();
      cell.before_previous[static_cast<std::size_t>(a)] =
          static_cast<std::int8_t>(-screen_.runs_away(there, d, a));
    }
    const double height = camera_.image_height();
    cell.top = static_cast<int>(std::floor(std::clamp(box.top, 0.0, height)));
    cell.bottom = static_cast<int>(std::min(std::floor(std::clamp(box.bottom, -1.0, height)) + 1, height));
    cell.is_large = is_large(box);
    if (cell.top < cell.bottom) require_in_reach(seen, std::max(box.right - box.left, box.bottom - box.top));
    return cell;
  }
  void require_in_reach(const Solid& seen, double across) const {
    const auto pixels = [](double n) { return std::to_string(static_cast<std::int64_t>(std::min(n, 1e15))); };
    if (options_.thickness == Thickness::physical && across > kMostPixels) {
      throw Error("a cell is " + pixels(across) + " pixels across, more than sheets are for (" +
                  std::to_string(kMostPixels) + "); take a greater width, or rays");
    }
    if (options_.thickness != Thickness::layers) return;
    const Extents e = extents(oriented(seen, screen_).solid, screen_);  // of which step counts are made
    const double most = std::max({e.across[0], e.across[1], e.length[2]});
    if (most > kMostSteps * options_.throttle) {
      throw Error("a cell takes points along " + pixels(most) + " pixels, more than the " +
                  std::to_string(kMostSteps) +
                  " steps that layers have; take a greater width or throttle, or physical thickness");
    }
  }
  [[nodiscard]] bool is_large(const ImageBox& box) const {
    constexpr double kPictures = 2;
    return box.right - box.left > kPictures * camera_.image_width() ||
           box.bottom - box.top > kPictures * camera_.image_height();
  }
  [[nodiscard]] bool is_outside(const ImageBox& box) const {
    return !(box.right >= 0 && box.left <= camera_.image_width() && box.bottom >= 0 &&
             box.top <= camera_.image_height());
  }
  [[nodiscard]] Solid solid(const VisibleCell& cell) const {
    const Dims first = first_cell(cell, block_cells_);
    return cell.level == 0 ? solids_[cell.block](first) : merged_[cell.block].solid(cell.level, first);
  }
  /// Of a place in the order.
  [[nodiscard]] const VisibleCell& cell_at(std::uint32_t ordered) const {
    return cells_[(ordered & kPart) != 0 ? parts_[ordered & ~kPart].cell : ordered];
  }
  [[nodiscard]] Solid solid_at(std::uint32_t ordered) const {
    const Solid whole = solid(cell_at(ordered));
    if ((ordered & kPart) == 0) return whole;
    const CellPart& of = parts_[ordered & ~kPart];
    return part(whole, of.low, of.high);
  }

  template <class Draw>
  static void each(std::vector<Band>& bands, const Draw& draw) {
    parallel_for(0, static_cast<std::int64_t>(bands.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t n = begin; n < end; ++n) draw(bands[static_cast<std::size_t>(n)]);
    });
  }
  /// By layers.
  void draw_cells(Band& band) const {
    for (const std::uint32_t n : order_) {
      const VisibleCell& cell = cell_at(n);
      if (cell.bottom <= band.top || cell.top >= band.bottom) continue;
      const Oriented put = oriented(solid_at(n), screen_);
      double share = 1;
      if ((n & kPart) != 0) share = (parts_[n & ~kPart].high - parts_[n & ~kPart].low)[put.axis];
      draw_layers(put.solid, screen_, table_, options_.throttle, share, band);
    }
  }

  /// Some cells, one after another, as sheets of triangles.
  class Run {
   public:
    Run(const Sheets& of, std::size_t begin, std::size_t end) : of_(&of), next_(begin), end_(end) {}
    SheetMeshes meshes;
    SheetCounts counts;
    [[nodiscard]] bool done() const { return next_ == end_ && parts_.empty() && !maker_; }
    /// Goes on until there are so many vertices.
    void make(std::size_t budget) {
      meshes.vertices.clear();
      meshes.meshes.clear();
      while (meshes.vertices.size() < budget && !done()) {
        if (maker_) {
          counts.points += maker_->make(budget, meshes);
          counts.sheets += meshes.meshes.back().surfaces - 1;
          if (maker_->done()) maker_.reset();
        } else {
          take_part();
        }
      }
    }

   private:
    struct Part {
      Solid solid;
      int halvings;
      bool is_large;
    };
    static constexpr int kMostHalvings = 6;
    static constexpr double kSheetsAValue = 1024;  // chosen: a thousandth of the colours each
    const Sheets* of_;
    std::size_t next_, end_;
    std::vector<Part> parts_;  // of a cell, the nearest last
    std::optional<SheetMaker> maker_;

    void take_part() {
      const Screen& screen = of_->screen_;
      if (parts_.empty()) {
        const std::uint32_t next = of_->order_[next_++];
        parts_.push_back({of_->solid_at(next), kMostHalvings, of_->cell_at(next).is_large});
      }
      Part part{oriented(parts_.back().solid, screen).solid, parts_.back().halvings, parts_.back().is_large};
      parts_.pop_back();
      int axis = -1;
      if (part.is_large) {
        const ImageBox box(part.solid, screen);
        if (of_->is_outside(box)) return;
        if (of_->is_large(box)) {
          const Extents e = extents(part.solid, screen);
          axis = static_cast<int>(std::max_element(e.across, e.across + 3) - e.across);
          ++part.halvings;  // one that does not count
        }
      }
      if (axis < 0 && part.halvings > 0) axis = axis_to_halve(part.solid, screen, of_->options_.throttle);
      if (axis < 0) {
        SheetFineness fineness = of_->fineness_;
        if (part.is_large) fineness.sheets_a_value = kSheetsAValue;
        maker_.emplace(part.solid, screen, fineness);
        return;
      }
      const std::array<Solid, 2> two = halves(part.solid, static_cast<std::size_t>(axis));
      Eigen::Matrix<double, 4, 3> d;
      const Vec3 centre = part.solid.centre(d).head<3>();
      const std::size_t front = screen.runs_away(centre, d, axis) >= 0 ? 0 : 1;
      parts_.push_back({two[1 - front], part.halvings - 1, part.is_large});
      parts_.push_back({two[front], part.halvings - 1, part.is_large});
    }
  };

  /// By physical thickness: vertices by runs of cells, then triangles by bands, some runs at a time.
  void scan(std::vector<std::vector<Band>>& pictures, SheetCounts& counts) const {
    constexpr std::size_t kRuns = 64, kMostCells = 64, kVertices = 1 << 14;
    const std::size_t cells = order_.size(), length = std::clamp<std::size_t>(cells / kRuns, 1, kMostCells);
    std::vector<Run> runs;
    for (std::size_t n = 0; n < cells; n += length) runs.emplace_back(*this, n, std::min(n + length, cells));
    std::vector<const SheetMeshes*> drawn;
    for (std::size_t first = 0; first < runs.size();) {
      const std::size_t last = std::min(first + kRuns, runs.size());
      parallel_for(static_cast<std::int64_t>(first), static_cast<std::int64_t>(last), 1,
                   [&](std::int64_t begin, std::int64_t end) {
                     for (auto n = static_cast<std::size_t>(begin); n < static_cast<std::size_t>(end); ++n) {
                       if (runs[n].meshes.meshes.empty()) runs[n].make(kVertices);
                     }
                   });
      // To the first that has more to come, and what it has so far.
      std::size_t whole = first;
      while (whole < last && runs[whole].done()) ++whole;
      drawn.clear();
      for (std::size_t n = first; n < std::min(whole + 1, last); ++n) drawn.push_back(&runs[n].meshes);
      for (std::size_t n = 0; n < pictures.size(); ++n)
        each(pictures[n], [&](Band& band) { scan_sheets(drawn, *tables_[n], band); });
      for (; first < whole; ++first) {
        counts.sheets += runs[first].counts.sheets;
        counts.points += runs[first].counts.points;
        runs[first].meshes = {};
      }
      if (whole < last) runs[whole].meshes.meshes.clear();
    }
  }
  static void store(const Band& band, image::Image& image) {
    for (int y = band.top; y < band.bottom; ++y) {
      for (int x = 0; x < band.width; ++x) {
        const std::size_t n = band.at(x, y);
        const Band::Pixel& pixel = band.pixels[n];
        const float channels[5] = {pixel.r, pixel.g, pixel.b, 1 - pixel.transmittance,
                                   static_cast<float>(band.samples[n])};
        for (int c = 0; c < 5; ++c) image.at(x, y, c) = channels[c];
      }
    }
  }
  /// What another picture is off by, at most over the channels, where that is more than before.
  static void store_difference(const Band& band, image::Image& image) {
    for (int y = band.top; y < band.bottom; ++y) {
      for (int x = 0; x < band.width; ++x) {
        const Band::Pixel& pixel = band.pixels[band.at(x, y)];
        const float channels[4] = {pixel.r, pixel.g, pixel.b, 1 - pixel.transmittance};
        for (int c = 0; c < 4; ++c)
          image.at(x, y, 5) = larger_error(image.at(x, y, 5), std::abs(channels[c] - image.at(x, y, c)));
      }
    }
  }
  static std::int64_t holes(const image::Image& image) {
    const auto met = [&](int x, int y) {
      return x >= 0 && x < image.width && y >= 0 && y < image.height && image.at(x, y, 4) > 0;
    };
    constexpr std::int64_t kGrain = 32;
    return parallel_reduce<std::int64_t>(
        0, image.height, kGrain,
        [&](std::int64_t top, std::int64_t bottom) {
          std::int64_t count = 0;
          for (int y = static_cast<int>(top); y < bottom; ++y) {
            for (int x = 0; x < image.width; ++x) {
              count += !met(x, y) && ((met(x - 1, y) && met(x + 1, y)) || (met(x, y - 1) && met(x, y + 1)));
            }
          }
          return count;
        },
        [](std::int64_t& sum, std::int64_t part) { sum += part; });
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
  if (options.thickness == Thickness::layers && (options.merge || options.sensitivity))
    throw Error("cells are merged and errors estimated by physical thickness alone");
  if (values.size() != grid.blocks.size()) throw Error("sheets need values for every block");
  return Sheets(grid, values, camera, transfer, reference_length, options).draw();
}

}  // namespace vol::curvilinear
