#include "render/footprint_splats.h"

#include <algorithm>
#include <utility>

#include "base/buffer.h"
#include "base/parallel.h"

namespace vol::render {
namespace {

/// Sums that stay in a core's own cache; at least so many rows, as a term is taken up anew in every block
/// that it reaches.
constexpr std::int64_t kBlockBytes = 256 << 10;
constexpr std::int64_t kLeastRows = 64;
constexpr std::int64_t kTasks = 16;
/// What the shares of terms hold together; wide pictures have fewer shares.
constexpr std::int64_t kShareBytes = 64 << 20;
/// Terms that are brought into the picture before they are drawn.
constexpr std::size_t kBatch = 256;

/// A part, what a term of it costs, and what those before it do.
struct Layer {
  const FootprintPart* part = nullptr;
  const std::vector<PixelRun>* window = nullptr;
  std::array<int, 2> face{};
  std::int64_t term_cost = 0, begin = 0, end = 0;
  std::vector<std::int64_t> offsets;
};

/// Parts in the order in which they are drawn: those of the same face together. Costs in about cycles of a
/// processor with vectors of 16 floats.
std::vector<Layer> make_layers(const std::vector<FootprintGroup>& groups, const FaceWindows& windows,
                               std::int64_t stride) {
  std::vector<Layer> layers;
  for (const auto& group : groups) {
    for (const auto& part : group.parts) {
      if (!part.phases || part.phases->columns.empty()) continue;
      Layer& layer = layers.emplace_back();
      layer.part = &part;
      if (part.cut >= 0) {
        layer.face = {part.cut, group.axis};
        layer.window =
            &windows.rows[static_cast<std::size_t>(part.cut)][static_cast<std::size_t>(group.axis)];
      } else {
        layer.face = {-1, 0};
      }
      const auto chunks = static_cast<std::int64_t>(part.phases->columns.size());
      layer.term_cost = 60 + chunks * (part.phases->taps == Taps::cubic ? 12 : 4);
      layer.offsets = part.phases->offsets(stride);
    }
  }
  std::stable_sort(layers.begin(), layers.end(),
                   [](const Layer& a, const Layer& b) { return a.face < b.face; });
  std::int64_t cost = 0;
  for (Layer& layer : layers) {
    layer.begin = cost;
    layer.end = cost += layer.term_cost * static_cast<std::int64_t>(layer.part->order.size());
  }
  return layers;
}

/// Largest magnitude of a coefficient times its part's amplitude: float holds ratios to it.
double largest_amplitude(const std::vector<Layer>& layers) {
  double largest = 0;
  for (const Layer& layer : layers) {
    double own = 0;
    for (const auto& term : layer.part->terms()) own = std::max(own, std::abs(term.c));
    largest = std::max(largest, own * std::abs(layer.part->amplitude));
  }
  return largest;
}

/// Rows of a picture, padded at both ends.
template <class T>
struct Block {
  PictureRows<T> rows;
  Buffer<T> values;

  Block(int width, std::int64_t stride, int first, int count)
      : values(static_cast<std::size_t>(stride * count), T{0}) {
    rows = {values.data() + kFootprintPadding, stride, width, first, count};
  }
};

/// to += from at the pixels of a face; from = 0.
template <class T>
void move_face(Block<T>& from, const std::vector<PixelRun>& window, Block<T>& to) {
  for (int y = 0; y < to.rows.count; ++y) {
    const PixelRun& run = window[static_cast<std::size_t>(to.rows.first + y)];
    const T* source = from.rows.values + y * from.rows.stride;
    T* target = to.rows.values + y * to.rows.stride;
    for (int x = run.begin; x < run.end; ++x) target[x] += source[x];
  }
  std::fill(from.values.begin(), from.values.end(), T{0});
}

/// Terms begin .. end - 1 of a part's order.
template <class T>
void add_terms(const Layer& layer, std::size_t begin, std::size_t end, double scale,
               const PictureRows<T>& rows) {
  const FootprintPart& part = *layer.part;
  const auto terms = part.terms();
  std::array<Splat, kBatch> splats;
  while (begin < end) {
    const std::size_t count = std::min(kBatch, end - begin);
    for (std::size_t n = 0; n < count; ++n) splats[n] = part.splat(terms[part.order[begin + n]], scale);
    add_splats(*part.phases, layer.offsets, {splats.data(), count}, rows);
    begin += count;
  }
}

/// What costs from .. to - 1, in some rows.
template <class T>
Block<T> sum_of_share(const std::vector<Layer>& layers, std::int64_t from, std::int64_t to, double unit,
                      Block<T> sums) {
  std::optional<Block<T>> face;
  const std::vector<PixelRun>* window = nullptr;
  for (const Layer& layer : layers) {
    if (layer.end <= from || layer.begin >= to) continue;
    const auto until = [&layer](std::int64_t cost) {  // the number of terms that begin before
      const std::int64_t within = std::clamp(cost, layer.begin, layer.end) - layer.begin;
      return static_cast<std::size_t>((within + layer.term_cost - 1) / layer.term_cost);
    };
    if (window != nullptr && window != layer.window) move_face(*face, *window, sums);
    window = layer.window;
    if (window != nullptr && !face) {
      face.emplace(sums.rows.width, sums.rows.stride, sums.rows.first, sums.rows.count);
    }
    add_terms(layer, until(from), until(to), layer.part->amplitude / unit,
              window != nullptr ? face->rows : sums.rows);
  }
  if (window != nullptr) move_face(*face, *window, sums);
  return sums;
}

template <class T>
std::vector<double> sum_of_layers(const std::vector<Layer>& layers, int width, int height,
                                  std::int64_t stride) {
  std::vector<double> picture(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  double unit = largest_amplitude(layers);
  if (!(unit > 0)) unit = 1;
  const std::int64_t row_bytes = stride * static_cast<std::int64_t>(sizeof(T));
  const auto fitting = kBlockBytes / row_bytes;
  const auto block_rows = static_cast<int>(std::min<std::int64_t>(std::max(fitting, kLeastRows), height));
  const std::int64_t blocks = (height + block_rows - 1) / block_rows;
  const std::int64_t shares = std::clamp<std::int64_t>(kShareBytes / (blocks * block_rows * row_bytes), 1,
                                                       std::max<std::int64_t>(1, kTasks / blocks));
  const std::int64_t cost = layers.back().end;
  std::vector<std::optional<Block<T>>> sums(static_cast<std::size_t>(blocks * shares));
  const auto block = [&](std::int64_t number) {
    const int first = static_cast<int>(number) * block_rows;
    return Block<T>(width, stride, first, std::min(block_rows, height - first));
  };
  const auto add_to_picture = [&](Block<T>& share, int from, int to) {
    for (int y = from; y < to; ++y) {
      const T* row = share.rows.values + (y - share.rows.first) * stride;
      double* out = picture.data() + static_cast<std::int64_t>(y) * width;
      for (int x = 0; x < width; ++x) out[x] += unit * static_cast<double>(row[x]);
    }
  };
  parallel_for(0, blocks * shares, 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto task = begin; task < end; ++task) {
      const std::int64_t share = task % shares;
      // cost * share / shares without overflow
      const auto until = [&](std::int64_t s) { return cost / shares * s + cost % shares * s / shares; };
      auto sum = sum_of_share(layers, until(share), until(share + 1), unit, block(task / shares));
      if (shares == 1) {
        add_to_picture(sum, sum.rows.first, sum.rows.first + sum.rows.count);
      } else {
        sums[static_cast<std::size_t>(task)].emplace(std::move(sum));
      }
    }
  });
  if (shares == 1) return picture;
  parallel_for(0, height, 16, [&](std::int64_t from, std::int64_t to) {
    for (auto& share : sums) {
      const int first = share->rows.first;
      add_to_picture(*share, std::max(static_cast<int>(from), first),
                     std::min(static_cast<int>(to), first + share->rows.count));
    }
  });
  return picture;
}

}  // namespace

std::vector<double> sum_of_splats(const std::vector<FootprintGroup>& groups, const FaceWindows& windows,
                                  int width, int height, bool in_float) {
  const std::int64_t stride = std::int64_t{width} + 2 * kFootprintPadding;
  const auto layers = make_layers(groups, windows, stride);
  if (layers.empty()) {
    return std::vector<double>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  }
  return in_float ? sum_of_layers<float>(layers, width, height, stride)
                  : sum_of_layers<double>(layers, width, height, stride);
}

}  // namespace vol::render
