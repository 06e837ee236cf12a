// Compiled once for every instruction set (Highway's foreach_target); the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "wavelet/footprint_kernel.cpp"
#include <hwy/foreach_target.h>  // before highway.h
#include <hwy/highway.h>

#include "wavelet/footprint_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace vol::wavelet::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Two vectors of columns for four rows stay in registers over all of j.
HWY_ATTR void add_product(const double* HWY_RESTRICT a, const double* HWY_RESTRICT b, std::int64_t begin,
                          std::int64_t end, double* HWY_RESTRICT sum, std::int64_t stride) {
  const hn::CappedTag<double, 8> d;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  for (std::int64_t c = 0; c < kFootprintColumns; c += 2 * lanes) {
    auto s00 = hn::Zero(d), s01 = hn::Zero(d), s10 = hn::Zero(d), s11 = hn::Zero(d);
    auto s20 = hn::Zero(d), s21 = hn::Zero(d), s30 = hn::Zero(d), s31 = hn::Zero(d);
    for (std::int64_t j = begin; j < end; ++j) {
      const double* HWY_RESTRICT at = a + j * kFootprintRows;
      const auto b0 = hn::LoadU(d, b + j * kFootprintColumns + c);
      const auto b1 = hn::LoadU(d, b + j * kFootprintColumns + c + lanes);
      const auto a0 = hn::Set(d, at[0]), a1 = hn::Set(d, at[1]), a2 = hn::Set(d, at[2]),
                 a3 = hn::Set(d, at[3]);
      s00 = hn::MulAdd(a0, b0, s00);
      s01 = hn::MulAdd(a0, b1, s01);
      s10 = hn::MulAdd(a1, b0, s10);
      s11 = hn::MulAdd(a1, b1, s11);
      s20 = hn::MulAdd(a2, b0, s20);
      s21 = hn::MulAdd(a2, b1, s21);
      s30 = hn::MulAdd(a3, b0, s30);
      s31 = hn::MulAdd(a3, b1, s31);
    }
    double* HWY_RESTRICT out = sum + c;
    const auto add = [&](double* at, auto v) HWY_ATTR { hn::StoreU(hn::Add(hn::LoadU(d, at), v), d, at); };
    add(out, s00);
    add(out + lanes, s01);
    add(out + stride, s10);
    add(out + stride + lanes, s11);
    add(out + 2 * stride, s20);
    add(out + 2 * stride + lanes, s21);
    add(out + 3 * stride, s30);
    add(out + 3 * stride + lanes, s31);
  }
}

}  // namespace vol::wavelet::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vol::wavelet {

HWY_EXPORT(add_product);

void add_product(const double* a, const double* b, std::int64_t begin, std::int64_t end, double* sum,
                 std::int64_t stride) {
  HWY_DYNAMIC_DISPATCH(add_product)(a, b, begin, end, sum, stride);
}

}  // namespace vol::wavelet
#endif
