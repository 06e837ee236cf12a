#include "transfer/opacity.h"

#include "kernels.h"
#include "truth.h"

namespace vol::stability {
namespace {

constexpr double kTiny = std::numeric_limits<double>::min();

/// From the smallest normal number to 1 less half an ulp.
const double kOpacities[] = {kTiny,
                             1e-300,
                             1e-100,
                             1e-30,
                             1e-16,
                             1e-8,
                             1e-3,
                             0.03,
                             0.1,
                             0.3,
                             0.47,
                             0.5,
                             0.53,
                             0.7,
                             0.9,
                             0.999,
                             1 - 1e-9,
                             1 - 0x1p-40,
                             1 - 21 * 0x1p-53,
                             1 - 20 * 0x1p-53,
                             1 - 2 * 0x1p-53,
                             1 - 0x1p-53};
const double kRatios[] = {1e-6, 1e-3, 0.37, 1, 2.5, 10, 1e3, 1e6};

/// |x - truth| over |truth|, where truth may be below the normal numbers.
double relative(double x, Real truth) {
  return static_cast<double>(std::abs(static_cast<Real>(x) - truth) /
                             (std::abs(truth) + static_cast<Real>(kTiny)));
}

void corrected(Table& table) {
  Worst worst, differing;
  for (const double a : kOpacities) {
    for (const double ratio : kRatios) {
      for (const double length : {1e-30, 1.0, 1e30}) {
        const double step = ratio * length;
        const Real r = static_cast<Real>(step) / static_cast<Real>(length);
        worst.add(relative(transfer::corrected_opacity(a, step, length),
                           -std::expm1(r * std::log1p(-static_cast<Real>(a)))),
                  8 * kDouble);
      }
    }
  }
  for (const double ratio : kRatios) {
    differing.add(std::abs(transfer::corrected_opacity(0, ratio, 1)), 0);
    differing.add(std::abs(transfer::corrected_opacity(1, ratio, 1) - 1), 0);
  }
  table.row("opacity from the smallest normal to 1 - ulp/2, steps of 1e-6 to 1e6 lengths",
            "corrected_opacity", "double", worst,
            "log1p, expm1 to 1 ulp, 2 roundings; condition of 1 - e^-x at most 1");
  table.row("opacity 0 and 1", "corrected_opacity", "double", differing, "exact");
}

void extinctions(Table& table) {
  Worst worst;
  for (const double a : kOpacities) {
    for (const double length : {1e-6, 1.0, 1e30}) {
      worst.add(relative(transfer::extinction(a, length),
                         -std::log1p(-static_cast<Real>(a)) / static_cast<Real>(length)),
                4 * kDouble);
    }
  }
  table.row("opacity from the smallest normal to 1 - ulp/2, lengths 1e-6 to 1e30", "extinction", "double",
            worst, "log1p to 1 ulp and a division");
}

void ramps(Table& table) {
  Worst worst;
  const auto add = [&](double a0, double a1) {
    const Real truth = tanh_sinh([&](Real u, Real v) { return ramp_depth(a0, a1, u, v); });
    // Ends apart: 1 less a quotient of about that size, whose rounding counts as the mean is smaller.
    const double apart = std::abs(a1 - a0) / (2 - a0 - a1);
    const double condition = apart < 0.05 ? 1 : std::max(1.0, static_cast<double>(1 / truth));
    worst.add(relative(transfer::mean_ramp_depth(a0, a1), truth), 24 * kDouble * condition);
  };
  for (const double a0 : kOpacities) {
    for (const double a1 : kOpacities) add(a0, a1);
    add(a0, 0);
    add(0, a0);
    add(a0, 1);
    add(1, a0);
  }
  table.row("ramps between all pairs of these, 0 and 1", "mean_ramp_depth", "double", worst,
            "24 roundings; of 1 where the ends are apart, over the mean");
}

}  // namespace

void opacity(Table& table) {
  corrected(table);
  extinctions(table);
  ramps(table);
}

}  // namespace vol::stability
