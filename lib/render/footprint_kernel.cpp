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

/// out += amplitude times a chunk of the taps' planes. Sums of taps are float.
template <int kTaps, int kChunk, class T>
HWY_INLINE void add_chunk(const FootprintTaps& taps, std::int64_t at, T amplitude, T* HWY_RESTRICT out) {
  const hn::CappedTag<T, kChunk> wide;
  const hn::Rebind<float, decltype(wide)> tag;
  const auto scale = hn::Set(wide, amplitude);
  const auto lanes = static_cast<int>(hn::Lanes(wide));
  for (int i = 0; i < kChunk; i += lanes) {
    const auto sum = sum_of_taps<kTaps>(tag, taps, at + i);
    const auto before = hn::LoadU(wide, out + i);
    if constexpr (sizeof(T) == sizeof(float)) {
      hn::StoreU(hn::MulAdd(scale, sum, before), wide, out + i);
    } else {
      hn::StoreU(hn::MulAdd(scale, hn::PromoteTo(wide, sum), before), wide, out + i);
    }
  }
}

template <int kTaps, int kChunk, class T>
HWY_INLINE void add_splats_of(const FootprintPhases& phases, const std::int64_t* offsets,
                              std::span<const Splat> splats, const PictureRows<T>& picture) {
  for (const Splat& splat : splats) {
    const int top = splat.row + phases.first_row;
    const int from = std::max(picture.first - top, 0);
    const int to = std::min(picture.first + picture.count - top, phases.rows);
    if (from >= to) continue;
    const int left = splat.column + phases.first_column;
    if (left + phases.columns_reached <= 0 || left >= picture.width) continue;
    FootprintTaps taps;
    find_taps<kTaps>(phases, splat, taps);
    const T amplitude = static_cast<T>(splat.amplitude);
    T* HWY_RESTRICT out = picture.values + (top - picture.first) * picture.stride + left;
    const std::int32_t begin = phases.begin[static_cast<std::size_t>(from)],
                       end = phases.begin[static_cast<std::size_t>(to)];
    // One loop over all rows: its end is foreseen better than those of many short ones.
    if (left >= -kFootprintPadding && left + phases.columns_reached <= picture.width + kFootprintPadding) {
      for (std::int32_t c = begin; c < end; ++c) {
        add_chunk<kTaps, kChunk>(taps, std::int64_t{c} * kChunk, amplitude, out + offsets[c]);
      }
      continue;
    }
    for (std::int32_t c = begin; c < end; ++c) {
      const int column = left + phases.columns[static_cast<std::size_t>(c)];
      if (column <= -kChunk || column >= picture.width) continue;
      add_chunk<kTaps, kChunk>(taps, std::int64_t{c} * kChunk, amplitude, out + offsets[c]);
    }
  }
}

template <class T>
HWY_INLINE void add_all_splats(const FootprintPhases& phases, const std::int64_t* offsets,
                               std::span<const Splat> splats, const PictureRows<T>& picture) {
  if (phases.taps == Taps::cubic) {
    if (phases.chunk == 8) {
      add_splats_of<16, 8>(phases, offsets, splats, picture);
    } else {
      add_splats_of<16, 16>(phases, offsets, splats, picture);
    }
  } else if (phases.chunk == 8) {
    add_splats_of<4, 8>(phases, offsets, splats, picture);
  } else {
    add_splats_of<4, 16>(phases, offsets, splats, picture);
  }
}

HWY_ATTR void add_splats_float(const FootprintPhases& phases, const std::int64_t* offsets,
                               std::span<const Splat> splats, const PictureRows<float>& picture) {
  add_all_splats(phases, offsets, splats, picture);
}

HWY_ATTR void add_splats_double(const FootprintPhases& phases, const std::int64_t* offsets,
                                std::span<const Splat> splats, const PictureRows<double>& picture) {
  add_all_splats(phases, offsets, splats, picture);
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

void add_splats(const FootprintPhases& phases, const std::vector<std::int64_t>& offsets,
                std::span<const Splat> splats, const PictureRows<float>& picture) {
  HWY_DYNAMIC_DISPATCH(add_splats_float)(phases, offsets.data(), splats, picture);
}

void add_splats(const FootprintPhases& phases, const std::vector<std::int64_t>& offsets,
                std::span<const Splat> splats, const PictureRows<double>& picture) {
  HWY_DYNAMIC_DISPATCH(add_splats_double)(phases, offsets.data(), splats, picture);
}

void add_octants(const OctantCell& cell, const OctantLevel& level, const RayRow& row, int begin, int end,
                 double* values) {
  HWY_DYNAMIC_DISPATCH(add_octants)(cell, level, row, begin, end, values);
}

std::vector<std::int64_t> FootprintPhases::offsets(std::int64_t stride) const {
  std::vector<std::int64_t> found(columns.size());
  for (std::size_t row = 0; row + 1 < begin.size(); ++row) {
    for (auto c = static_cast<std::size_t>(begin[row]); c < static_cast<std::size_t>(begin[row + 1]); ++c) {
      found[c] = columns[c] + static_cast<std::int64_t>(row) * stride;
    }
  }
  return found;
}

double splat_value(const FootprintPhases& phases, const Splat& splat, int column, int row) {
  const int i = column - splat.column - phases.first_column, j = row - splat.row - phases.first_row;
  if (j < 0 || j >= phases.rows) return 0;
  FootprintTaps taps;
  const bool cubic = phases.taps == Taps::cubic;
  if (cubic) {
    find_taps<16>(phases, splat, taps);
  } else {
    find_taps<4>(phases, splat, taps);
  }
  double sum = 0;
  for (auto c = phases.begin[static_cast<std::size_t>(j)]; c < phases.begin[static_cast<std::size_t>(j) + 1];
       ++c) {
    const int within = i - phases.columns[static_cast<std::size_t>(c)];
    if (within < 0 || within >= phases.chunk) continue;
    for (int t = 0; t < (cubic ? 16 : 4); ++t) {
      sum += static_cast<double>(taps.weight[t]) *
             static_cast<double>(taps.plane[t][std::int64_t{c} * phases.chunk + within]);
    }
  }
  return static_cast<double>(splat.amplitude) * sum;
}

}  // namespace vol::render
#endif
