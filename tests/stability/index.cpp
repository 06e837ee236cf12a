#include "index/build_index.h"

#include "base/rng.h"
#include "index/whole_index.h"
#include "kernels.h"
#include "wavelet/dwt.h"
#include "wavelet/filters.h"

// Entries of index volumes against what their definition, or a theorem, says: how many differ.
namespace vol::stability {
namespace {

using namespace vol::index;

struct Setting {
  Dims dims;
  Vec3 spacing{1, 1, 1};
  int levels = 2;
  double epsilon = 0.3, scale = 1, offset = 0, distance = 0.4;
  std::string wavelet = "daubechies-4";
};

template <class T>
volume::Volume field(const Setting& s) {
  volume::Grid<T> grid;
  grid.geometry.dims = s.dims;
  grid.geometry.spacing = s.spacing;
  grid.voxels = Buffer<T>(static_cast<std::size_t>(grid.geometry.count()));
  Rng rng(11);
  std::size_t n = 0;
  for (std::int64_t k = 0; k < s.dims[2]; ++k) {
    for (std::int64_t j = 0; j < s.dims[1]; ++j) {
      for (std::int64_t i = 0; i < s.dims[0]; ++i) {
        const double noisy = i + j + k < (s.dims[0] + s.dims[1] + s.dims[2]) / 3 ? rng.normal() : 0.0;
        grid.voxels[n++] =
            static_cast<T>(s.offset + s.scale * (std::sin(0.1 * double(i + 2 * j - k)) + noisy));
      }
    }
  }
  return {std::move(grid), {}};
}

SignificanceOptions significance(const Setting& s) {
  SignificanceOptions options;
  options.epsilon = s.epsilon * s.scale;
  return options;
}

template <class T>
wavelet::Decomposition<T> decomposed(const volume::Volume& v, const Setting& s) {
  return wavelet::analyze<T>(v, {.wavelet = s.wavelet, .levels = s.levels}, volume::value_range(v));
}

template <class T>
IndexVolume index_of(const Setting& s) {
  const auto v = field<T>(s);
  IndexOptions options;
  options.standard_distance = s.distance;
  return build_index(significant_details(decomposed<T>(v, s), significance(s)), v.geometry(), options);
}

template <class F>
double differing(const IndexVolume& a, const F& expected) {
  double count = 0;
  const Dims& n = a.dims();
  for (std::int64_t k = 0; k < n[2]; ++k) {
    for (std::int64_t j = 0; j < n[1]; ++j) {
      for (std::int64_t i = 0; i < n[0]; ++i) count += a.entry(i, j, k) != expected(i, j, k);
    }
  }
  return count;
}
double differing(const IndexVolume& a, const IndexVolume& b) {
  return differing(a, [&](std::int64_t i, std::int64_t j, std::int64_t k) { return b.entry(i, j, k); });
}

/// Against the definition, on whole fields.
void definition(Table& table, const std::string& what, const std::vector<Setting>& settings) {
  double count = 0;
  for (const Setting& s : settings) {
    const auto v = field<float>(s);
    IndexOptions options;
    options.standard_distance = s.distance;
    const auto found = whole::build_index(whole::significant_voxels(decomposed<float>(v, s), significance(s)),
                                          v.geometry(), options);
    count += differing(index_of<float>(s), found);
  }
  table.row(what, "build_index", "float", count, 0, "the definition, voxel by voxel");
}

template <class T>
void theorems(Table& table, const char* precision) {
  const Setting plain{.dims = {33, 18, 21}, .levels = 3};
  const IndexVolume base = index_of<T>(plain);
  Setting s = plain;
  // Powers of two near 1e30 and 1e-30: no rounding differs.
  for (const auto& [what, scale] :
       {std::pair{"values of 2^100 = 1.3e30", 0x1p100}, {"values of 2^-100 = 7.9e-31", 0x1p-100}}) {
    s.scale = scale;
    table.row(what, "build_index", precision, differing(index_of<T>(s), base), 0,
              "scaling field and epsilon by 2^k changes no entry");
  }
  if (sizeof(T) == 8) {
    s = plain;
    s.offset = 1e8;
    table.row("signal 1 on 1e8", "build_index", precision, differing(index_of<T>(s), base), 0,
              "wavelets do not see constants; details below 8 ulp do not count");
  }
  double count = 0;
  for (const double offset : {1e30, 1e-30, 1e8, 0.0}) {
    for (const auto& wavelet : wavelet::wavelet_names()) {
      if (!wavelet::make_wavelet(wavelet).orthonormal) continue;  // truncated: their g does not add up to 0
      const Setting constant{
          .dims = {16, 8, 24}, .levels = 3, .epsilon = 0, .scale = 0, .offset = offset, .wavelet = wavelet};
      count += differing(index_of<T>(constant), [](std::int64_t, std::int64_t, std::int64_t) { return 3; });
    }
  }
  table.row("constants 1e30, 1e-30, 1e8, 0, epsilon 0, all orthonormal wavelets", "build_index", precision,
            count, 0, "no detail but rounding, below 8 ulp: the largest step everywhere");
  s = plain;
  s.epsilon = std::numeric_limits<double>::infinity();
  table.row("epsilon infinite", "build_index", precision,
            differing(index_of<T>(s), [](std::int64_t, std::int64_t, std::int64_t) { return 3; }), 0,
            "the largest step everywhere");
  const int last = 6;
  s = plain;
  s.dims = {64, 64, 64};
  s.levels = last;
  s.epsilon = 1e30;
  s.wavelet = "haar";
  table.row("64^3 to the last level, epsilon 1e30", "build_index", precision,
            differing(index_of<T>(s), [](std::int64_t, std::int64_t, std::int64_t) { return last; }), 0,
            "the largest step everywhere");
}

}  // namespace

void index(Table& table) {
  definition(table, "sizes 1, 2, 3 and primes",
             {{.dims = {1, 1, 1}},
              {.dims = {2, 2, 2}, .levels = 1},
              {.dims = {3, 3, 3}},
              {.dims = {2, 1, 3}},
              {.dims = {13, 17, 11}},
              {.dims = {1, 31, 7}, .levels = 3}});
  definition(table, "1 x 1 x 4096", {{.dims = {1, 1, 4096}, .levels = 6}});
  definition(table, "spacing ratio 1e4",
             {{.dims = {12, 9, 14}, .spacing = {1e-2, 1, 100}},
              {.dims = {12, 9, 14}, .spacing = {100, 1, 1e-2}, .distance = 0.005}});
  definition(table, "distance 1e-6 and 1e6 voxels",
             {{.dims = {13, 9, 14}, .distance = 1e-6}, {.dims = {13, 9, 14}, .distance = 1e6}});
  theorems<float>(table, "float");
  theorems<double>(table, "double");
}

}  // namespace vol::stability
