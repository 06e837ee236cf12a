#include "volume/compare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "base/compensated_sum.h"
#include "base/error.h"
#include "base/parallel.h"

namespace vol::volume {
namespace {

constexpr std::int64_t kGrain =
    1 << 14;  // voxels a task: two rows of doubles that stay in the second-level cache

void load(const Volume& volume, std::int64_t begin, std::int64_t end, std::vector<double>& values) {
  values.resize(static_cast<std::size_t>(end - begin));
  visit(volume, [&](const auto& grid) {
    for (std::size_t n = 0; n < values.size(); ++n) {
      values[n] = static_cast<double>(grid.voxels[static_cast<std::size_t>(begin) + n]);
    }
  });
}

/// Calls f(tested, reference, first) on stretches of both volumes as doubles, folds the results in order.
template <class Part, class F, class Fold>
Part over_both(const Volume& tested, const Volume& reference, const F& f, const Fold& fold) {
  return parallel_reduce<Part>(
      0, reference.geometry().count(), kGrain,
      [&](std::int64_t begin, std::int64_t end) {
        std::vector<double> t;
        std::vector<double> r;
        load(tested, begin, end, t);
        load(reference, begin, end, r);
        return f(t, r, begin);
      },
      fold);
}

struct Survey {
  double largest = 0;  // finite magnitude in either volume
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  std::int64_t nan = 0;
  std::int64_t infinite = 0;
};

Survey survey(const Volume& tested, const Volume& reference) {
  return over_both<Survey>(
      tested, reference,
      [](const std::vector<double>& t, const std::vector<double>& r, std::int64_t) {
        Survey part;
        for (const auto* values : {&t, &r}) {
          for (const double value : *values) {
            if (!std::isfinite(value)) {
              ++(std::isnan(value) ? part.nan : part.infinite);
              continue;
            }
            part.largest = std::max(part.largest, std::abs(value));
            if (values != &r) continue;
            part.min = std::min(part.min, value);
            part.max = std::max(part.max, value);
          }
        }
        return part;
      },
      [](Survey& total, const Survey& part) {
        total.largest = std::max(total.largest, part.largest);
        total.min = std::min(total.min, part.min);
        total.max = std::max(total.max, part.max);
        total.nan += part.nan;
        total.infinite += part.infinite;
      });
}

struct Sums {
  CompensatedSum squares;
  CompensatedSum absolutes;
  CompensatedSum reference_squares;
  double maximum = 0;
  std::int64_t maximum_at = -1;
  std::int64_t differing = 0;
};

/// Sums of scale (t - r) and scale r.
Sums sums(const Volume& tested, const Volume& reference, double scale) {
  return over_both<Sums>(
      tested, reference,
      [scale](const std::vector<double>& t, const std::vector<double>& r, std::int64_t first) {
        Sums part;
        for (std::size_t n = 0; n < t.size(); ++n) {
          const double d = t[n] == r[n] ? 0.0 : std::abs(scale * t[n] - scale * r[n]);
          part.differing += !(t[n] == r[n]);
          part.squares.add(d * d);
          part.absolutes.add(d);
          part.reference_squares.add((scale * r[n]) * (scale * r[n]));
          if (d > part.maximum || (std::isnan(d) && !std::isnan(part.maximum))) {
            part.maximum = d;
            part.maximum_at = first + static_cast<std::int64_t>(n);
          }
        }
        return part;
      },
      [](Sums& total, const Sums& part) {
        total.squares.add(part.squares);
        total.absolutes.add(part.absolutes);
        total.reference_squares.add(part.reference_squares);
        total.differing += part.differing;
        if (part.maximum > total.maximum || (std::isnan(part.maximum) && !std::isnan(total.maximum))) {
          total.maximum = part.maximum;
          total.maximum_at = part.maximum_at;
        }
      });
}

/// Power of two that brings values too large or too small to be squared near 1; 1 for all others.
double safe_scale(double largest) {
  if (largest == 0 || (largest < 0x1p400 && largest > 0x1p-400)) return 1;
  return std::ldexp(1.0, std::clamp(-std::ilogb(largest), -1022, 1022));
}

double ratio(double a, double b) {
  return a == 0 && b == 0 ? 0 : a / b;
}

std::string text(const Vec3& v) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, "%.9g,%.9g,%.9g", v[0], v[1], v[2]);
  return buffer;
}

}  // namespace

VolumeError compare(const Volume& tested, const Volume& reference) {
  const Dims& a = tested.geometry().dims;
  const Dims& b = reference.geometry().dims;
  if (a != b) {
    const auto name = [](const Dims& d) {
      return std::to_string(d[0]) + "x" + std::to_string(d[1]) + "x" + std::to_string(d[2]);
    };
    throw Error("dims differ: " + name(a) + " against " + name(b));
  }
  const Survey seen = survey(tested, reference);
  const double scale = safe_scale(seen.largest);
  const Sums total = sums(tested, reference, scale);
  const auto count = static_cast<double>(reference.geometry().count());

  VolumeError error;
  if (seen.min <= seen.max) error.reference_range = {seen.min, seen.max};
  error.nan = seen.nan;
  error.infinite = seen.infinite;
  error.differing = total.differing;
  const double rmse = std::sqrt(total.squares.value() / count);  // of the scaled values
  const double range = error.reference_range.max * scale - error.reference_range.min * scale;
  error.rmse = rmse / scale;
  error.mse = scale == 1 ? total.squares.value() / count : error.rmse * error.rmse;
  error.mae = total.absolutes.value() / count / scale;
  error.maximum = total.maximum / scale;
  if (total.maximum_at >= 0) {
    error.maximum_at = {total.maximum_at % b[0], total.maximum_at / b[0] % b[1],
                        total.maximum_at / b[0] / b[1]};
  }
  error.rmse_byte = 255 * ratio(rmse, range);
  error.psnr =
      rmse == 0 ? std::numeric_limits<double>::infinity() : 20 * (std::log10(range) - std::log10(rmse));
  error.relative_l2 = ratio(std::sqrt(total.squares.value()), std::sqrt(total.reference_squares.value()));
  return error;
}

std::vector<std::string> geometry_differences(const GridGeometry& tested, const GridGeometry& reference) {
  std::vector<std::string> found;
  const auto differ = [&](const std::string& what, const std::string& a, const std::string& b) {
    found.push_back(what + " " + a + " against " + b);
  };
  const double voxel = reference.spacing.minCoeff();
  if (((tested.spacing - reference.spacing).array().abs() > 1e-6 * reference.spacing.array()).any()) {
    differ("spacing", text(tested.spacing), text(reference.spacing));
  }
  if ((tested.origin - reference.origin).cwiseAbs().maxCoeff() > 1e-4 * voxel) {
    differ("origin", text(tested.origin), text(reference.origin));
  }
  for (int axis = 0; axis < 3; ++axis) {
    if ((tested.direction.col(axis) - reference.direction.col(axis)).cwiseAbs().maxCoeff() > 1e-5) {
      differ(std::string("direction of ") + "ijk"[axis], text(tested.direction.col(axis)),
             text(reference.direction.col(axis)));
    }
  }
  if (tested.space != reference.space)
    differ("space", std::string(name(tested.space)), std::string(name(reference.space)));
  return found;
}

}  // namespace vol::volume
