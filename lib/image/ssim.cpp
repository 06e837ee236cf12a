#include "image/ssim.h"

#include <cmath>
#include <limits>

#include "base/compensated_sum.h"
#include "base/error.h"

namespace vol::image {

const std::array<double, kSsimWindow>& ssim_weights() {
  static const auto weights = [] {
    std::array<double, kSsimWindow> w{};
    double sum = 0;
    for (int k = 0; k < kSsimWindow; ++k) {
      const double distance = k - kSsimWindow / 2;
      w[static_cast<std::size_t>(k)] = std::exp(-distance * distance / (2 * kSsimSigma * kSsimSigma));
      sum += w[static_cast<std::size_t>(k)];
    }
    for (double& weight : w) weight /= sum;
    return w;
  }();
  return weights;
}

namespace {

/// Calls visit(weight, x, y) for the pixels of the window whose first pixel is (column, row).
template <class F>
void for_window(const Image& x, int xc, const Image& y, int yc, int column, int row, const F& visit) {
  const auto& w = ssim_weights();
  for (int j = 0; j < kSsimWindow; ++j) {
    for (int i = 0; i < kSsimWindow; ++i) {
      visit(w[static_cast<std::size_t>(i)] * w[static_cast<std::size_t>(j)],
            static_cast<double>(x.at(column + i, row + j, xc)),
            static_cast<double>(y.at(column + i, row + j, yc)));
    }
  }
}

}  // namespace

double ssim_reference(const Image& x, int x_channel, const Image& y, int y_channel, double peak) {
  if (x.width != y.width || x.height != y.height)
    throw Error("structural similarity of images of different size");
  if (x.width < kSsimWindow || x.height < kSsimWindow) return std::numeric_limits<double>::quiet_NaN();
  const double c1 = (kSsimK1 * peak) * (kSsimK1 * peak);
  const double c2 = (kSsimK2 * peak) * (kSsimK2 * peak);
  CompensatedSum sum;
  const int columns = x.width - kSsimWindow + 1;
  const int rows = x.height - kSsimWindow + 1;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      double mu_x = 0;
      double mu_y = 0;
      for_window(x, x_channel, y, y_channel, column, row, [&](double w, double a, double b) {
        mu_x += w * a;
        mu_y += w * b;
      });
      double var_x = 0;
      double var_y = 0;
      double cov = 0;
      for_window(x, x_channel, y, y_channel, column, row, [&](double w, double a, double b) {
        var_x += w * (a - mu_x) * (a - mu_x);
        var_y += w * (b - mu_y) * (b - mu_y);
        cov += w * (a - mu_x) * (b - mu_y);
      });
      sum.add((2 * mu_x * mu_y + c1) * (2 * cov + c2) /
              ((mu_x * mu_x + mu_y * mu_y + c1) * (var_x + var_y + c2)));
    }
  }
  return sum.value() / (static_cast<double>(columns) * rows);
}

}  // namespace vol::image
