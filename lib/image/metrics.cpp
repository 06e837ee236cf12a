#include "image/metrics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/compensated_sum.h"
#include "base/error.h"
#include "base/parallel.h"
#include "image/ssim.h"

namespace vol::image {
namespace {

// A tile is what one thread holds in its second-level cache: 42 rows of 282 doubles, twice. The cut is fixed,
// so that the order of summation is.
constexpr int kTileWidth = 256;
constexpr int kTileHeight = 32;
constexpr int kHalo = kSsimWindow - 1;
constexpr std::size_t kStride = kTileWidth + kHalo + kSsimPadding;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Figures {
  CompensatedSum squares;
  CompensatedSum absolutes;
  CompensatedSum similarities;
  double maximum = 0;
  std::int64_t maximum_at = -1;  // y width + x
  std::int64_t nan_tested = 0;
  std::int64_t nan_reference = 0;
  std::int64_t infinite_tested = 0;
  std::int64_t infinite_reference = 0;

  [[nodiscard]] bool finite() const {
    return nan_tested + nan_reference + infinite_tested + infinite_reference == 0;
  }
};

/// True where a maximum m at pixel p comes before the one at q: NaN before all, then the larger, then the
/// earlier.
bool outranks(double m, std::int64_t p, double n, std::int64_t q) {
  if (p < 0 || q < 0) return p >= 0;
  if (std::isnan(m) || std::isnan(n)) return std::isnan(m) && (!std::isnan(n) || p < q);
  return m > n || (m == n && p < q);
}

void fold(Figures& total, const Figures& part) {
  total.squares.add(part.squares);
  total.absolutes.add(part.absolutes);
  total.similarities.add(part.similarities);
  if (outranks(part.maximum, part.maximum_at, total.maximum, total.maximum_at)) {
    total.maximum = part.maximum;
    total.maximum_at = part.maximum_at;
  }
  total.nan_tested += part.nan_tested;
  total.nan_reference += part.nan_reference;
  total.infinite_tested += part.infinite_tested;
  total.infinite_reference += part.infinite_reference;
}

/// t - r with equal infinities equal.
double difference(double t, double r) {
  return t == r ? 0.0 : t - r;
}

/// One channel of both images on one tile.
class Tile {
 public:
  Tile(const Image& tested, const Image& reference, int x0, int y0)
      : tested_(tested), reference_(reference), x0_(x0), y0_(y0) {
    own_columns_ = static_cast<std::size_t>(std::min(kTileWidth, tested.width - x0));
    own_rows_ = static_cast<std::size_t>(std::min(kTileHeight, tested.height - y0));
  }

  Figures measure(const ChannelPair& pair, const ErrorOptions& options) {
    Figures figures;
    const std::size_t columns = options.ssim ? with_halo(tested_.width - x0_, kTileWidth) : own_columns_;
    const std::size_t rows = options.ssim ? with_halo(tested_.height - y0_, kTileHeight) : own_rows_;
    bool finite = true;
    for (std::size_t row = 0; row < rows; ++row) {
      finite = load(pair, row, columns) && finite;
      if (row < own_rows_) add_differences(row, figures);
    }
    if (!finite) {
      count_non_finite(pair, figures);
    } else if (options.ssim && columns >= kSsimWindow && rows >= kSsimWindow) {
      add_similarity(rows, columns, options.peak, figures);
    }
    return figures;
  }

 private:
  const Image& tested_;
  const Image& reference_;
  int x0_;
  int y0_;
  std::size_t own_columns_;
  std::size_t own_rows_;

  // Memory of a thread, used from tile to tile; zero at first, so that what a vector reads past a row's end
  // is at least a number.
  struct Memory {
    Buffer<double> s = Buffer<double>(kStride * (kTileHeight + kHalo) + kSsimPadding, 0.0);
    Buffer<double> d = s;
    Buffer<double> scratch = Buffer<double>(5 * kStride, 0.0);
  };
  static Memory& memory() {
    thread_local Memory m;
    return m;
  }

  static std::size_t with_halo(int left, int tile) {
    return static_cast<std::size_t>(std::min(left, tile + kHalo));
  }

  [[nodiscard]] const float* row_of(const Image& image, int channel, std::size_t row) const {
    return &image.at(x0_, y0_ + static_cast<int>(row), channel);
  }

  /// Sums and differences of a row; false where it holds NaN or infinity.
  bool load(const ChannelPair& pair, std::size_t row, std::size_t columns) {
    const float* t = row_of(tested_, pair.tested, row);
    const float* r = row_of(reference_, pair.reference, row);
    const std::size_t t_step = tested_.channels.size();
    const std::size_t r_step = reference_.channels.size();
    double* s = memory().s.data() + row * kStride;
    double* d = memory().d.data() + row * kStride;
    std::uint32_t largest = 0;  // of the magnitudes' bit patterns, which sort as the magnitudes do, NaN last
    for (std::size_t x = 0; x < columns; ++x) {
      const float a = t[x * t_step];
      const float b = r[x * r_step];
      largest =
          std::max({largest, std::bit_cast<std::uint32_t>(a) << 1, std::bit_cast<std::uint32_t>(b) << 1});
      s[x] = static_cast<double>(a) + static_cast<double>(b);
      d[x] = static_cast<double>(a) - static_cast<double>(b);
    }
    constexpr std::uint32_t kInfinity = 0x7f800000u << 1;
    if (largest < kInfinity) return true;
    for (std::size_t x = 0; x < columns; ++x) d[x] = difference(t[x * t_step], r[x * r_step]);
    return false;
  }

  void add_differences(std::size_t row, Figures& figures) const {
    const double* d = memory().d.data() + row * kStride;
    std::array<double, 8> squares{};  // eight sums, so that the compiler may use vectors of any width
    std::array<double, 8> absolutes{};
    std::array<double, 8> largest{};
    const auto add = [&](std::size_t lane, double value) {
      const double magnitude = std::abs(value);
      squares[lane] += value * value;
      absolutes[lane] += magnitude;
      largest[lane] = magnitude > largest[lane] ? magnitude : largest[lane];
    };
    std::size_t x = 0;
    for (; x + 8 <= own_columns_; x += 8) {
      for (std::size_t lane = 0; lane < 8; ++lane) add(lane, d[x + lane]);
    }
    for (; x < own_columns_; ++x) add(x % 8, d[x]);
    double row_squares = 0;
    double row_absolutes = 0;
    double row_largest = 0;
    for (std::size_t lane = 0; lane < 8; ++lane) {
      row_squares += squares[lane];
      row_absolutes += absolutes[lane];
      row_largest = std::max(row_largest, largest[lane]);
    }
    figures.squares.add(row_squares);
    figures.absolutes.add(row_absolutes);
    if (std::isnan(row_squares)) row_largest = kNaN;  // comparisons pass over NaN, the sum does not
    if (std::isnan(figures.maximum) || !(std::isnan(row_largest) || row_largest > figures.maximum)) return;
    const auto is_it = [&](double value) {
      return std::isnan(row_largest) ? std::isnan(value) : std::abs(value) == row_largest;
    };
    const auto at = std::find_if(d, d + own_columns_, is_it) - d;
    figures.maximum = row_largest;
    figures.maximum_at = (std::int64_t{y0_} + static_cast<std::int64_t>(row)) * tested_.width + x0_ + at;
  }

  void count_non_finite(const ChannelPair& pair, Figures& figures) const {
    for (std::size_t row = 0; row < own_rows_; ++row) {
      const float* t = row_of(tested_, pair.tested, row);
      const float* r = row_of(reference_, pair.reference, row);
      for (std::size_t x = 0; x < own_columns_;
           ++x, t += tested_.channels.size(), r += reference_.channels.size()) {
        figures.nan_tested += std::isnan(*t);
        figures.nan_reference += std::isnan(*r);
        figures.infinite_tested += std::isinf(*t);
        figures.infinite_reference += std::isinf(*r);
      }
    }
  }

  /// Mean of a plane of the tile, and the plane without it.
  static double take_off_mean(Buffer<double>& plane, std::size_t rows, std::size_t columns) {
    double sum = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      std::array<double, 8> part{};
      const double* p = plane.data() + row * kStride;
      std::size_t x = 0;
      for (; x + 8 <= columns; x += 8) {
        for (std::size_t lane = 0; lane < 8; ++lane) part[lane] += p[x + lane];
      }
      for (; x < columns; ++x) part[x % 8] += p[x];
      for (const double value : part) sum += value;
    }
    const double mean = sum / static_cast<double>(rows * columns);
    if (mean == 0) return 0;
    for (std::size_t row = 0; row < rows; ++row) {
      double* p = plane.data() + row * kStride;
      for (std::size_t x = 0; x < columns; ++x) p[x] -= mean;
    }
    return mean;
  }

  void add_similarity(std::size_t rows, std::size_t columns, double peak, Figures& figures) const {
    Memory& m = memory();
    SsimTile tile{};
    tile.s0 = take_off_mean(m.s, rows, columns);
    tile.d0 = take_off_mean(m.d, rows, columns);
    tile.s = m.s.data();
    tile.d = m.d.data();
    tile.stride = kStride;
    tile.columns = std::min(columns - kHalo, own_columns_);
    tile.rows = std::min(rows - kHalo, own_rows_);
    tile.c1 = (kSsimK1 * peak) * (kSsimK1 * peak);
    tile.c2 = (kSsimK2 * peak) * (kSsimK2 * peak);
    tile.scratch = m.scratch.data();
    figures.similarities.add(ssim_sum(tile));
  }
};

void require_comparable(const Image& tested, const Image& reference, const std::vector<ChannelPair>& channels,
                        double peak) {
  if (tested.width != reference.width || tested.height != reference.height) {
    throw Error("sizes differ: " + std::to_string(tested.width) + "x" + std::to_string(tested.height) +
                " against " + std::to_string(reference.width) + "x" + std::to_string(reference.height));
  }
  if (channels.empty()) throw Error("no channels to compare");
  for (const auto& pair : channels) {
    if (pair.tested < 0 || pair.tested >= static_cast<int>(tested.channels.size()) || pair.reference < 0 ||
        pair.reference >= static_cast<int>(reference.channels.size())) {
      throw Error("channel " + pair.name + " is not in both images");
    }
  }
  if (!(peak > 0) || !std::isfinite(peak))
    throw Error("peak " + std::to_string(peak) + ": expected a positive number");
}

ChannelError channel_error(const ChannelPair& pair, const Figures& figures, const Image& image, bool ssim) {
  const double pixels = static_cast<double>(image.width) * image.height;
  ChannelError error;
  error.name = pair.name;
  error.mse = figures.squares.value() / pixels;
  error.mae = figures.absolutes.value() / pixels;
  error.maximum = figures.maximum;
  if (figures.maximum_at >= 0) {
    error.maximum_x = static_cast<int>(figures.maximum_at % image.width);
    error.maximum_y = static_cast<int>(figures.maximum_at / image.width);
    error.maximum_channel = pair.name;
  }
  const double windows =
      static_cast<double>(std::max(0, image.width - kHalo)) * std::max(0, image.height - kHalo);
  error.ssim = ssim && windows > 0 && figures.finite() ? figures.similarities.value() / windows : kNaN;
  error.nan_tested = figures.nan_tested;
  error.nan_reference = figures.nan_reference;
  error.infinite_tested = figures.infinite_tested;
  error.infinite_reference = figures.infinite_reference;
  return error;
}

ChannelError together(const std::vector<ChannelError>& channels) {
  ChannelError all;
  all.name = "all";
  CompensatedSum mse;
  CompensatedSum mae;
  CompensatedSum ssim;
  for (const auto& channel : channels) {
    mse.add(channel.mse);
    mae.add(channel.mae);
    ssim.add(channel.ssim);
    const bool larger =
        std::isnan(channel.maximum) ? !std::isnan(all.maximum) : channel.maximum > all.maximum;
    if (larger) {
      all.maximum = channel.maximum;
      all.maximum_x = channel.maximum_x;
      all.maximum_y = channel.maximum_y;
      all.maximum_channel = channel.name;
    }
    all.nan_tested += channel.nan_tested;
    all.nan_reference += channel.nan_reference;
    all.infinite_tested += channel.infinite_tested;
    all.infinite_reference += channel.infinite_reference;
  }
  const auto n = static_cast<double>(channels.size());
  all.mse = mse.value() / n;
  all.mae = mae.value() / n;
  all.ssim = ssim.value() / n;
  return all;
}

}  // namespace

double rmse(const ChannelError& error) {
  return std::sqrt(error.mse);
}
double rmse_byte(const ChannelError& error, double peak) {
  return rmse(error) * (255 / peak);
}
double mse_byte(const ChannelError& error, double peak) {
  return rmse_byte(error, peak) * rmse_byte(error, peak);
}
double psnr(const ChannelError& error, double peak) {
  return 20 * std::log10(peak) - 10 * std::log10(error.mse);
}

ImageError compare(const Image& tested, const Image& reference, const std::vector<ChannelPair>& channels,
                   const ErrorOptions& options) {
  require_comparable(tested, reference, channels, options.peak);
  const std::int64_t tiles_x = (tested.width + kTileWidth - 1) / kTileWidth;
  const std::int64_t tiles_y = (tested.height + kTileHeight - 1) / kTileHeight;
  using Partial = std::vector<Figures>;  // a channel each
  const Partial total = parallel_reduce<Partial>(
      0, tiles_x * tiles_y, 1,
      [&](std::int64_t n, std::int64_t) {
        Tile tile(tested, reference, static_cast<int>(n % tiles_x) * kTileWidth,
                  static_cast<int>(n / tiles_x) * kTileHeight);
        Partial partial;
        for (const auto& pair : channels) partial.push_back(tile.measure(pair, options));
        return partial;
      },
      [](Partial& sum, const Partial& partial) {
        sum.resize(partial.size());
        for (std::size_t c = 0; c < partial.size(); ++c) fold(sum[c], partial[c]);
      });
  ImageError error;
  error.peak = options.peak;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    error.channels.push_back(channel_error(channels[c], total[c], tested, options.ssim));
  }
  error.all = together(error.channels);
  return error;
}

}  // namespace vol::image
