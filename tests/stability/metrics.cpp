#include "image/metrics.h"

#include "base/rng.h"
#include "image/ssim.h"
#include "kernels.h"
#include "truth.h"

// Figures of images against sums in long double.
namespace vol::stability {
namespace {

using namespace vol::image;

/// SSIM as its definition says it, in long double, about each window's own means; and the sum of what
/// rounding may do to it: of each variance and twice the covariance 1e-15 of the square of the picture's
/// range (ssim.h), over the window's denominator.
struct Similarity {
  Real mean = 0;
  double uncertain = 0;
};
Similarity similarity(const Image& x, const Image& y, double peak) {
  const auto& w = ssim_weights();
  const Real c1 = std::pow(0.01L * static_cast<Real>(peak), 2),
             c2 = std::pow(0.03L * static_cast<Real>(peak), 2);
  const auto [low, high] = std::minmax_element(x.pixels.begin(), x.pixels.end());
  const auto [low_y, high_y] = std::minmax_element(y.pixels.begin(), y.pixels.end());
  const Real range = static_cast<Real>(std::max(*high, *high_y)) - static_cast<Real>(std::min(*low, *low_y));
  Similarity result;
  Real windows = 0;
  for (int j = 0; j + kSsimWindow <= x.height; ++j) {
    for (int i = 0; i + kSsimWindow <= x.width; ++i) {
      Real mx = 0, my = 0, vx = 0, vy = 0, cov = 0;
      const auto each = [&](const auto& f) {
        for (int b = 0; b < kSsimWindow; ++b) {
          for (int a = 0; a < kSsimWindow; ++a)
            f(static_cast<Real>(w[static_cast<std::size_t>(a)]) *
                  static_cast<Real>(w[static_cast<std::size_t>(b)]),
              static_cast<Real>(x.at(i + a, j + b, 0)), static_cast<Real>(y.at(i + a, j + b, 0)));
        }
      };
      each([&](Real g, Real p, Real q) {
        mx += g * p;
        my += g * q;
      });
      each([&](Real g, Real p, Real q) {
        vx += g * (p - mx) * (p - mx);
        vy += g * (q - my) * (q - my);
        cov += g * (p - mx) * (q - my);
      });
      result.mean += (2 * mx * my + c1) * (2 * cov + c2) / ((mx * mx + my * my + c1) * (vx + vy + c2));
      result.uncertain += static_cast<double>(4e-15L * (1 + range * range / (vx + vy + c2)));
      ++windows;
    }
  }
  result.mean /= windows;
  result.uncertain /= static_cast<double>(windows);
  return result;
}

void figures(Table& table, const std::string& what, double scale, double offset, double difference,
             double peak, const std::vector<std::pair<int, int>>& sizes) {
  Worst mse, mae, maximum, psnrs, ssims;
  Rng rng(14);
  for (const auto& [width, height] : sizes) {
    Image a(width, height, {"Y"}), b = a;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double v = offset + scale * (std::sin(0.1 * x) * std::cos(0.07 * y) + 0.1 * rng.normal());
        a.at(x, y, 0) = static_cast<float>(v);
        b.at(x, y, 0) = static_cast<float>(v + difference * rng.normal());
      }
    }
    const ImageError found = compare(a, b, {{"Y", 0, 0}}, {.peak = peak});
    Real squares = 0, absolutes = 0, largest = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n) {
      const Real d = static_cast<Real>(a.pixels[n]) - static_cast<Real>(b.pixels[n]);
      squares += d * d;
      absolutes += std::abs(d);
      largest = std::max(largest, std::abs(d));
    }
    const auto pixels = static_cast<Real>(a.pixels.size());
    const auto relative = [](double x, Real y) {
      return y == 0 ? std::abs(x) : static_cast<double>(std::abs(x - y) / y);
    };
    mse.add(relative(found.all.mse, squares / pixels), 1e-14);
    mae.add(relative(found.all.mae, absolutes / pixels), 1e-14);
    // The difference of two floats is rounded to double once.
    maximum.add(relative(found.all.maximum, largest), kDouble);
    // Equal pictures are infinitely good.
    if (squares == 0) psnrs.add(std::isinf(psnr(found.all, peak)) ? 0 : 1, 0);
    if (squares > 0)
      psnrs.add(
          static_cast<double>(std::abs(psnr(found.all, peak) - (20 * std::log10(static_cast<Real>(peak)) -
                                                                10 * std::log10(squares / pixels)))),
          1e-13 + 4 * kDouble * (20 * std::abs(std::log10(peak)) + std::abs(psnr(found.all, peak))));
    if (width >= kSsimWindow && height >= kSsimWindow) {
      const Similarity truth = similarity(a, b, peak);
      ssims.add(static_cast<double>(std::abs(found.all.ssim - truth.mean)), truth.uncertain);
    }
  }
  table.row(what, "compare, mse", "double", mse, "compensated sums: 1e-14, as metrics.h states");
  table.row(what, "compare, mae", "double", mae, "compensated sums: 1e-14, as metrics.h states");
  table.row(what, "compare, maximum", "double", maximum, "one rounding");
  table.row(what, "psnr", "double", psnrs, "1e-14 of the mean square, 4 roundings of logarithms");
  if (ssims.count() > 0)
    table.row(what, "compare, ssim", "double", ssims,
              "variances to 4e-15 of the squared range, over the denominator");
}

}  // namespace

void metrics(Table& table) {
  const std::vector<std::pair<int, int>> sizes{{37, 53}, {257, 33}, {523, 17}};
  figures(table, "pictures of 0 to 1", 1, 0, 0.05, 1, sizes);
  figures(table, "nearly equal pictures, 1e-7 apart", 1, 0, 1e-7, 1, sizes);
  figures(table, "values 1e30", 1e30, 0, 1e29, 1e30, sizes);
  figures(table, "values 1e-30", 1e-30, 0, 1e-31, 1e-30, sizes);
  figures(table, "signal 100 on 1e8", 100, 1e8, 20, 100, sizes);
  figures(table, "1 x 1, 2 x 3, 1 x 4096", 1, 0, 0.05, 1, {{1, 1}, {2, 3}, {1, 4096}, {4096, 1}});
  figures(table, "equal pictures", 1, 0, 0, 1, {{37, 53}});
  table.refusal("pictures of different sizes", "compare", "double", [] {
    (void)compare(Image(2, 2, {"Y"}), Image(2, 3, {"Y"}), {{"Y", 0, 0}});
  });
  table.refusal("a peak of 0", "compare", "double", [] {
    (void)compare(Image(2, 2, {"Y"}), Image(2, 2, {"Y"}), {{"Y", 0, 0}}, {.peak = 0});
  });
}

}  // namespace vol::stability
