// Compiled once for every instruction set (Highway's foreach_target); the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/footprint_kernel.cpp"
#include <hwy/foreach_target.h>  // before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "render/footprint_kernel.h"
#include "render/footprint_taps.h"

HWY_BEFORE_NAMESPACE();
namespace vol::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Lanes of a picture: sums of taps are made in float and added to it as T.
template <class T>
struct PictureLanes;
template <>
struct PictureLanes<float> {
  hn::ScalableTag<float> sum, out;
  template <class V>
  HWY_INLINE V promoted(V v) const {
    return v;
  }
};
template <>
struct PictureLanes<double> {
  hn::CappedTag<double, 8> out;
  hn::Rebind<float, hn::CappedTag<double, 8>> sum;
  template <class V>
  HWY_INLINE auto promoted(V v) const {
    return hn::PromoteTo(out, v);
  }
};

/// Sum of the taps at a place of their planes.
template <int kTaps, class D>
HWY_INLINE hn::Vec<D> sum_of_taps(D tag, const FootprintTaps& taps, std::int64_t at) {
  auto even = hn::Mul(hn::Set(tag, taps.weight[0]), hn::LoadU(tag, taps.plane[0] + at));
  auto odd = hn::Mul(hn::Set(tag, taps.weight[1]), hn::LoadU(tag, taps.plane[1] + at));
  for (int t = 2; t < kTaps; t += 2) {
    even = hn::MulAdd(hn::Set(tag, taps.weight[t]), hn::LoadU(tag, taps.plane[t] + at), even);
    odd = hn::MulAdd(hn::Set(tag, taps.weight[t + 1]), hn::LoadU(tag, taps.plane[t + 1] + at), odd);
  }
  return hn::Add(even, odd);
}

template <int kTaps, class T>
HWY_INLINE void add_row(const FootprintTaps& taps, std::int64_t offset, T amplitude, int begin, int end,
                        T* HWY_RESTRICT out) {
  const PictureLanes<T> picture;
  const auto tag = picture.sum;
  const auto lanes = static_cast<int>(hn::Lanes(tag));
  const auto scale = hn::Set(picture.out, amplitude);
  for (int i = begin; i < end; i += lanes) {
    auto sum = picture.promoted(sum_of_taps<kTaps>(tag, taps, offset + i));
    if (i + lanes > end) {
      sum = hn::IfThenElseZero(hn::FirstN(picture.out, static_cast<std::size_t>(end - i)), sum);
    }
    hn::StoreU(hn::MulAdd(scale, sum, hn::LoadU(picture.out, out + i)), picture.out, out + i);
  }
}

/// A row in whole chunks of columns.
template <int kTaps, int kChunk, class T>
HWY_INLINE void add_chunks(const FootprintTaps& taps, std::int64_t offset, int count, const T* weights,
                           T* HWY_RESTRICT out) {
  const hn::CappedTag<T, kChunk> wide;
  const hn::Rebind<float, decltype(wide)> tag;
  const auto lanes = static_cast<int>(hn::Lanes(tag));
  for (int i = 0; i < count * kChunk; i += lanes) {
    const auto sum = sum_of_taps<kTaps>(tag, taps, offset + i);
    if constexpr (sizeof(T) == sizeof(float)) {
      hn::StoreU(hn::MulAdd(hn::Set(wide, *weights), sum, hn::LoadU(wide, out + i)), wide, out + i);
    } else {
      hn::StoreU(hn::MulAdd(hn::Set(wide, *weights), hn::PromoteTo(wide, sum), hn::LoadU(wide, out + i)),
                 wide, out + i);
    }
  }
}

template <int kTaps, int kChunk, class T>
HWY_INLINE void add_splats_of(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                              const PictureRows<T>& picture) {
  for (std::size_t s = 0; s < count; ++s) {
    const Splat& splat = splats[s];
    const int top = splat.row + phases.first_row;
    const int from = std::max(picture.first - top, 0);
    const int to = std::min(picture.first + picture.count - top, phases.rows);
    if (from >= to) continue;
    const int left = splat.column + phases.first_column;
    if (left + phases.columns <= 0 || left >= picture.width) continue;
    FootprintTaps taps;
    find_taps<kTaps>(phases, splat, taps);
    const T amplitude = static_cast<T>(splat.amplitude);
    T* HWY_RESTRICT out = picture.values + (top + from - picture.first) * picture.stride + left;
    if (picture.window == nullptr && left >= kColumnMargin &&
        left + phases.stride <= picture.width + kFootprintPadding) {
      const FootprintPhases::Chunks* chunks = phases.chunks.data();
      for (int row = from; row < to; ++row, out += picture.stride) {
        add_chunks<kTaps, kChunk>(taps, row * phases.stride + chunks[row].begin, chunks[row].count,
                                  &amplitude, out + chunks[row].begin);
      }
      continue;
    }
    for (int row = from; row < to; ++row, out += picture.stride) {
      const int line = top + row - picture.first;
      int begin = std::max(phases.runs[static_cast<std::size_t>(row)].begin, -left);
      int end = std::min(phases.runs[static_cast<std::size_t>(row)].end, picture.width - left);
      if (picture.window != nullptr) {
        begin = std::max(begin, picture.window[line].begin - left);
        end = std::min(end, picture.window[line].end - left);
      }
      if (begin < end) add_row<kTaps>(taps, row * phases.stride, amplitude, begin, end, out);
    }
  }
}

template <class T>
HWY_INLINE void add_all_splats(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                               const PictureRows<T>& picture) {
  if (phases.taps == Taps::cubic) {
    if (phases.chunk == 8) {
      add_splats_of<16, 8>(phases, splats, count, picture);
    } else {
      add_splats_of<16, 16>(phases, splats, count, picture);
    }
  } else if (phases.chunk == 8) {
    add_splats_of<4, 8>(phases, splats, count, picture);
  } else {
    add_splats_of<4, 16>(phases, splats, count, picture);
  }
}

HWY_ATTR void add_splats_float(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                               const PictureRows<float>& picture) {
  add_all_splats(phases, splats, count, picture);
}

HWY_ATTR void add_splats_double(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                                const PictureRows<double>& picture) {
  add_all_splats(phases, splats, count, picture);
}

HWY_ATTR void add_octants(const OctantCell& cell, const OctantLevel& level, const RayRow& row, int begin,
                          int end, double* HWY_RESTRICT values) {
  const hn::CappedTag<double, 8> tag;
  using V = hn::Vec<decltype(tag)>;
  const auto lanes = static_cast<int>(hn::Lanes(tag));
  const V infinite = hn::Set(tag, 1e300), none = hn::Set(tag, -1e300), zero = hn::Zero(tag);
  // q = (x + shift) / scale - k - lower counts units from the cell's begin; knots at 0, (width / 2,) width.
  double knot[3][3], inverse[3], dq[3];
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double width = level.upper[i] - level.lower[i];
    knot[a][0] = 0;
    knot[a][1] = cell.halves[i] == 2 ? 0.5 * width : width;
    knot[a][2] = width;
    dq[a] = row.direction[i] * (1 / level.scale[i]);
    inverse[a] = dq[a] == 0 ? 0 : 1 / dq[a];
  }
  const int nx = cell.halves[0], ny = cell.halves[1], nz = cell.halves[2];
  for (int x = begin; x < end; x += lanes) {
    const auto live = hn::FirstN(tag, static_cast<std::size_t>(std::min(end - x, lanes)));
    const V half = hn::MaskedLoad(live, tag, row.half + x);
    V low[3][2], high[3][2];
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      const V place = hn::MaskedLoad(live, tag, row.middle[a] + x);
      // The scale is a power of two: its reciprocal is exact.
      const V unit = hn::Mul(hn::Add(place, hn::Set(tag, level.shift[i])), hn::Set(tag, 1 / level.scale[i]));
      const V q0 = hn::Sub(hn::Sub(unit, hn::Set(tag, cell.k[i])), hn::Set(tag, level.lower[i]));
      for (int h = 0; h < cell.halves[i]; ++h) {
        const V from = hn::Set(tag, knot[a][h]), to = hn::Set(tag, knot[a][h + 1]);
        if (dq[a] == 0) {
          const auto inside = hn::And(hn::Ge(q0, from), hn::Lt(q0, to));
          low[a][h] = hn::IfThenElse(inside, none, infinite);
          high[a][h] = hn::IfThenElse(inside, infinite, none);
        } else {
          V s, t;
          if (std::abs(dq[a]) > 1e-6) {
            s = hn::Mul(hn::Sub(from, q0), hn::Set(tag, inverse[a]));
            t = hn::Mul(hn::Sub(to, q0), hn::Set(tag, inverse[a]));
          } else {
            s = hn::Div(hn::Sub(from, q0), hn::Set(tag, dq[a]));
            t = hn::Div(hn::Sub(to, q0), hn::Set(tag, dq[a]));
          }
          low[a][h] = hn::Min(s, t);
          high[a][h] = hn::Max(s, t);
        }
      }
    }
    V sum = zero;
    for (int k = 0; k < nz; ++k) {
      const V low_z = hn::Max(low[2][k], hn::Neg(half)), high_z = hn::Min(high[2][k], half);
      for (int j = 0; j < ny; ++j) {
        const V low_yz = hn::Max(low[1][j], low_z), high_yz = hn::Min(high[1][j], high_z);
        for (int i = 0; i < nx; ++i) {
          const V length = hn::Sub(hn::Min(high[0][i], high_yz), hn::Max(low[0][i], low_yz));
          const V value = hn::Set(tag, cell.value[static_cast<std::size_t>(i + 2 * j + 4 * k)]);
          sum = hn::MulAdd(value, hn::Max(length, zero), sum);
        }
      }
    }
    sum = hn::IfThenElseZero(live, sum);
    hn::StoreU(hn::Add(hn::LoadU(tag, values + x), sum), tag, values + x);
  }
}

}  // namespace vol::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::render {

HWY_EXPORT(add_splats_float);
HWY_EXPORT(add_splats_double);
HWY_EXPORT(add_octants);

void add_splats(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                const PictureRows<float>& picture) {
  HWY_DYNAMIC_DISPATCH(add_splats_float)(phases, splats, count, picture);
}

void add_splats(const FootprintPhases& phases, const Splat* splats, std::size_t count,
                const PictureRows<double>& picture) {
  HWY_DYNAMIC_DISPATCH(add_splats_double)(phases, splats, count, picture);
}

void add_octants(const OctantCell& cell, const OctantLevel& level, const RayRow& row, int begin, int end,
                 double* values) {
  HWY_DYNAMIC_DISPATCH(add_octants)(cell, level, row, begin, end, values);
}

double splat_value(const FootprintPhases& phases, const Splat& splat, int column, int row) {
  const int i = column - splat.column - phases.first_column, j = row - splat.row - phases.first_row;
  if (j < 0 || j >= phases.rows) return 0;
  const auto& run = phases.runs[static_cast<std::size_t>(j)];
  if (i < run.begin || i >= run.end) return 0;
  FootprintTaps taps;
  const bool cubic = phases.taps == Taps::cubic;
  if (cubic) {
    find_taps<16>(phases, splat, taps);
  } else {
    find_taps<4>(phases, splat, taps);
  }
  double sum = 0;
  for (int t = 0; t < (cubic ? 16 : 4); ++t) {
    sum += static_cast<double>(taps.weight[t]) * static_cast<double>(taps.plane[t][j * phases.stride + i]);
  }
  return splat.amplitude * sum;
}

}  // namespace vol::render
#endif
