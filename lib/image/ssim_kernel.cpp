// Compiled once for every instruction set (Highway's foreach_target); the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "image/ssim_kernel.cpp"
#include <hwy/foreach_target.h>  // before highway.h
#include <hwy/highway.h>

#include "image/ssim.h"

HWY_BEFORE_NAMESPACE();
namespace vol::image::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// One row of windows. Products and sums are rounded apart (no fused multiply-add), and lanes never meet but
// in the last, scalar sum, so that every instruction set gives the same bits.
HWY_ATTR void ssim_row(const SsimTile& t, std::size_t row, const double* HWY_RESTRICT w) {
  const hn::ScalableTag<double> tag;
  const std::size_t lanes = hn::Lanes(tag);
  double* HWY_RESTRICT vs = t.scratch;
  double* HWY_RESTRICT vd = vs + t.stride;
  double* HWY_RESTRICT vss = vd + t.stride;
  double* HWY_RESTRICT vdd = vss + t.stride;
  double* HWY_RESTRICT out = vdd + t.stride;

  // Down the columns.
  for (std::size_t x = 0; x < t.columns + kSsimWindow - 1; x += lanes) {
    auto sum_s = hn::Zero(tag);
    auto sum_d = hn::Zero(tag);
    auto sum_ss = hn::Zero(tag);
    auto sum_dd = hn::Zero(tag);
    for (std::size_t k = 0; k < kSsimWindow; ++k) {
      const auto weight = hn::Set(tag, w[k]);
      const auto s = hn::LoadU(tag, t.s + (row + k) * t.stride + x);
      const auto d = hn::LoadU(tag, t.d + (row + k) * t.stride + x);
      const auto ws = hn::Mul(weight, s);
      const auto wd = hn::Mul(weight, d);
      sum_s = hn::Add(sum_s, ws);
      sum_d = hn::Add(sum_d, wd);
      sum_ss = hn::Add(sum_ss, hn::Mul(ws, s));
      sum_dd = hn::Add(sum_dd, hn::Mul(wd, d));
    }
    hn::StoreU(sum_s, tag, vs + x);
    hn::StoreU(sum_d, tag, vd + x);
    hn::StoreU(sum_ss, tag, vss + x);
    hn::StoreU(sum_dd, tag, vdd + x);
  }

  // Along the row; the profile is symmetric, so pairs are added before they are weighted.
  constexpr std::size_t kCentre = kSsimWindow / 2;
  const auto filtered = [&](const double* HWY_RESTRICT v) HWY_ATTR {
    auto sum = hn::Mul(hn::Set(tag, w[kCentre]), hn::LoadU(tag, v + kCentre));
    for (std::size_t k = 0; k < kCentre; ++k) {
      const auto pair = hn::Add(hn::LoadU(tag, v + k), hn::LoadU(tag, v + kSsimWindow - 1 - k));
      sum = hn::Add(sum, hn::Mul(hn::Set(tag, w[k]), pair));
    }
    return sum;
  };
  const auto zero = hn::Zero(tag);
  const auto half = hn::Set(tag, 0.5);
  const auto c1 = hn::Set(tag, t.c1);
  const auto c2 = hn::Set(tag, t.c2);
  for (std::size_t x = 0; x < t.columns; x += lanes) {
    const auto s = filtered(vs + x);
    const auto d = filtered(vd + x);
    const auto var_s = hn::Max(zero, hn::Sub(filtered(vss + x), hn::Mul(s, s)));
    const auto var_d = hn::Max(zero, hn::Sub(filtered(vdd + x), hn::Mul(d, d)));
    const auto mu_s = hn::Add(hn::Set(tag, t.s0), s);
    const auto mu_d = hn::Add(hn::Set(tag, t.d0), d);
    const auto mu_ss = hn::Mul(mu_s, mu_s);
    const auto mu_dd = hn::Mul(mu_d, mu_d);
    const auto above = hn::Mul(hn::Add(hn::Mul(half, hn::Sub(mu_ss, mu_dd)), c1),
                               hn::Add(hn::Mul(half, hn::Sub(var_s, var_d)), c2));
    const auto below = hn::Mul(hn::Add(hn::Mul(half, hn::Add(mu_ss, mu_dd)), c1),
                               hn::Add(hn::Mul(half, hn::Add(var_s, var_d)), c2));
    hn::StoreU(hn::Div(above, below), tag, out + x);
  }
}

HWY_ATTR void ssim_rows(const SsimTile& tile, double* row_sums) {
  const double* w = ssim_weights().data();
  const double* out = tile.scratch + 4 * tile.stride;
  for (std::size_t row = 0; row < tile.rows; ++row) {
    ssim_row(tile, row, w);
    double part[8] = {};  // eight sums whatever the vector's width
    for (std::size_t x = 0; x < tile.columns; ++x) part[x % 8] += out[x];
    row_sums[row] = ((part[0] + part[1]) + (part[2] + part[3])) + ((part[4] + part[5]) + (part[6] + part[7]));
  }
}

}  // namespace vol::image::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <vector>

#include "base/compensated_sum.h"

namespace vol::image {

HWY_EXPORT(ssim_rows);

double ssim_sum(const SsimTile& tile) {
  std::vector<double> rows(tile.rows);
  HWY_DYNAMIC_DISPATCH(ssim_rows)(tile, rows.data());
  CompensatedSum sum;
  for (const double row : rows) sum.add(row);
  return sum.value();
}

}  // namespace vol::image
#endif
