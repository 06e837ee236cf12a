#include "isosurface/inside_bits.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "base/parallel.h"
#include "volume/voxel_type.h"

namespace vol::isosurface {
namespace {

using volume::half;

/// The samples at least the isovalue are those at least `least`, compared in their own type; none if `never`.
template <class T>
struct Threshold {
  T least{};
  bool never = false;

  explicit Threshold(double isovalue) {
    if constexpr (std::is_integral_v<T>) {
      const double up = std::ceil(isovalue);
      never = up > static_cast<double>(std::numeric_limits<T>::max());
      if (!never) {
        constexpr auto kLowest = static_cast<double>(std::numeric_limits<T>::lowest());
        least = static_cast<T>(up > kLowest ? up : kLowest);
      }
    } else {
      // Beyond the type's range rounding gives its infinity, which no sample reaches.
      least = static_cast<T>(isovalue);
      if (static_cast<double>(least) < isovalue)
        least = std::nextafter(least, std::numeric_limits<T>::infinity());
    }
  }
};

/// 64 samples or fewer to a word.
template <class T>
std::uint64_t word_of(const T* samples, std::int64_t n, T least) {
  std::uint8_t flag[64] = {};
  if (n >= 64) {
    for (int i = 0; i < 64; ++i) flag[i] = samples[i] >= least;  // a vector loop: the trip count is fixed
  } else {
    for (std::int64_t i = 0; i < n; ++i) flag[i] = samples[i] >= least;
  }
  std::uint64_t word = 0;
  for (int byte = 0; byte < 8; ++byte) {
    std::uint64_t eight;
    std::memcpy(&eight, flag + 8 * byte, 8);
    // Bit 8 i of the factor's product gathers flag i into bit 56 + i.
    word |= (eight * 0x0102040810204080u >> 56) << (8 * byte);
  }
  return word;
}

/// The row's words, moved up by one bit where the grid is padded.
template <class T>
void fill_row(const T* samples, std::int64_t n, const Threshold<T>& threshold, int pad, std::uint64_t* row,
              std::int64_t words) {
  std::uint64_t carry = 0;
  for (std::int64_t w = 0; w < words; ++w) {
    const std::int64_t left = n - 64 * w;
    const std::uint64_t word = left > 0 ? word_of(samples + 64 * w, left, threshold.least) : 0;
    row[w] = pad != 0 ? word << 1 | carry : word;
    carry = word >> 63;
  }
}

InsideBits::Row row_kind(const std::uint64_t* row, std::int64_t words, std::int64_t n) {
  std::uint64_t any = 0;
  std::uint64_t all = ~std::uint64_t{0};
  for (std::int64_t w = 0; w + 1 < words; ++w) {
    any |= row[w];
    all &= row[w];
  }
  const std::int64_t left = n - 64 * (words - 1);
  const std::uint64_t mask = left == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << left) - 1;
  any |= row[words - 1];
  all &= row[words - 1] | ~mask;
  return any == 0 ? InsideBits::Row::outside : ~all == 0 ? InsideBits::Row::inside : InsideBits::Row::mixed;
}

template <class T>
InsideBits make_bits(const T* samples, const Dims& dims, double isovalue, int pad) {
  InsideBits result;
  for (int a = 0; a < 3; ++a) result.dims[a] = dims[a] + 2 * pad;
  result.words = (result.dims[0] + 63) / 64;
  const std::int64_t rows = result.dims[1] * result.dims[2];
  result.bits = Buffer<std::uint64_t>(static_cast<std::size_t>(rows * result.words));
  result.rows = Buffer<InsideBits::Row>(static_cast<std::size_t>(rows));
  const Threshold<T> threshold(isovalue);
  parallel_for(0, rows, std::max<std::int64_t>(1, (1 << 17) / result.dims[0]),
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t r = begin; r < end; ++r) {
                   const std::int64_t j = r % result.dims[1] - pad;
                   const std::int64_t k = r / result.dims[1] - pad;
                   std::uint64_t* row = result.bits.data() + r * result.words;
                   if (threshold.never || j < 0 || k < 0 || j >= dims[1] || k >= dims[2]) {
                     std::memset(row, 0, static_cast<std::size_t>(result.words) * 8);
                   } else {
                     fill_row(samples + dims[0] * (j + dims[1] * k), dims[0], threshold, pad, row,
                              result.words);
                   }
                   result.rows[static_cast<std::size_t>(r)] = row_kind(row, result.words, result.dims[0]);
                 }
               });
  return result;
}

}  // namespace

template <class T>
InsideBits inside_bits(const T* samples, const Dims& dims, double isovalue, int pad) {
  if constexpr (std::is_same_v<T, half>) {
    // Compared as floats, row by row.
    const auto count = static_cast<std::size_t>(dims[0] * dims[1] * dims[2]);
    Buffer<float> wide(count);
    parallel_for(0, static_cast<std::int64_t>(count), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t n = begin; n < end; ++n) wide[static_cast<std::size_t>(n)] = samples[n];
    });
    return make_bits(wide.data(), dims, isovalue, pad);
  } else {
    return make_bits(samples, dims, isovalue, pad);
  }
}

template InsideBits inside_bits(const std::int8_t*, const Dims&, double, int);
template InsideBits inside_bits(const std::uint8_t*, const Dims&, double, int);
template InsideBits inside_bits(const std::int16_t*, const Dims&, double, int);
template InsideBits inside_bits(const std::uint16_t*, const Dims&, double, int);
template InsideBits inside_bits(const std::int32_t*, const Dims&, double, int);
template InsideBits inside_bits(const std::uint32_t*, const Dims&, double, int);
template InsideBits inside_bits(const half*, const Dims&, double, int);
template InsideBits inside_bits(const float*, const Dims&, double, int);
template InsideBits inside_bits(const double*, const Dims&, double, int);

}  // namespace vol::isosurface
