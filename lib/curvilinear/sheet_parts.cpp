#include "curvilinear/sheet_parts.h"

#include <algorithm>

#include "curvilinear/forward_difference.h"

namespace vol::curvilinear {

TransferTable::TransferTable(const transfer::TransferFunction& transfer, double thinned_by, double off) {
  const double low = transfer.breakpoints().front(), high = transfer.breakpoints().back();
  const double by = off * (high > low ? high - low : 1);
  const auto opacity = [&](double value) {
    return by > 0   ? transfer.max_opacity(value - by, value + by)
           : by < 0 ? transfer.min_opacity(value + by, value - by)
                    : transfer.opacity(value);
  };
  const auto add = [&](double value) {
    const Vec3 c = transfer.colour(value + by);
    entries_.push_back({static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]),
                        static_cast<float>(-std::log1p(-opacity(value)) / thinned_by)});
  };
  origin_ = low;
  entries_.reserve(kEntries + 3);
  add(std::nextafter(low, -std::numeric_limits<double>::infinity()));
  if (high > low) {
    if (1 / (high - low) > std::numeric_limits<double>::max()) scale_ = 0x1p100;
    per_value_ = 1 / ((high - low) * scale_);
    end_ = 1;
    // Rounding may take a value just below the end one step too far: there is one more.
    for (int n = 0; n <= kEntries; ++n) {
      add(std::min(high, low + (high - low) * (n + 0.5) / kEntries));
    }
  }
  add(high);
}

Oriented oriented(const Solid& seen, const Screen& screen) {
  Eigen::Matrix<double, 4, 3> d;
  const Vec3 centre = seen.centre(d).head<3>();
  const Vec3 ray = screen.direction(centre);
  int depth_axis = 2;
  double largest = -1, forward = 1;
  const double jacobian = d.topRows<3>().determinant();
  for (int a = 0; a < 3; ++a) {
    const Vec3 du = d.col((a + 1) % 3).head<3>(), dv = d.col((a + 2) % 3).head<3>();
    const double area = du.cross(dv).dot(ray);
    if (std::abs(area) > largest) {
      largest = std::abs(area);
      depth_axis = a;
      // The parameter grows along the ray by area / jacobian a length.
      forward = jacobian != 0 ? area * jacobian : d.col(a).head<3>().dot(ray);
    }
  }
  constexpr std::size_t kStride[3] = {1, 4, 16};
  const std::size_t u = kStride[(depth_axis + 1) % 3], v = kStride[(depth_axis + 2) % 3],
                    w = kStride[depth_axis];
  Oriented put{{}, depth_axis};
  for (std::size_t n = 0; n < 64; ++n) {
    const std::size_t t = n / 16;
    put.solid.b[n] = seen.b[u * (n % 4) + v * (n / 4 % 4) + w * (forward < 0 ? 3 - t : t)];
  }
  return put;
}

LargestDifferences::LargestDifferences(const Solid& seen, const Point4& origin) {
  Eigen::Array4f b[64], d[64];
  for (std::size_t n = 0; n < 64; ++n) b[n] = (seen.b[n] - origin).cast<float>().array();
  mixed.setZero();
  for (std::size_t a = 0, stride = 1; a < 3; ++a, stride *= 4) {
    first[a].setZero();
    second[a].setZero();
    for (std::size_t n = 0; n < 64; ++n) {
      const std::size_t at = n / stride % 4;
      if (at == 3) continue;
      d[n] = b[n + stride] - b[n];
      first[a] = first[a].max(d[n].abs());
      if (at > 0) second[a] = second[a].max((d[n] - d[n - stride]).abs());
      if (a == 0 && n / 4 % 4 > 0) mixed = mixed.max((d[n] - d[n - 4]).abs());
    }
  }
}

Extents extents(const Solid& seen, const LargestDifferences& differences, const Screen& screen) {
  Extents e;
  std::array<Eigen::Vector2d, 64> image;
  double pixels = screen.is_perspective() ? 0 : 1;
  if (screen.is_perspective()) {
    for (std::size_t n = 0; n < 64; ++n) {
      image[n] = screen.project(seen.b[n].head<3>());
      pixels = std::max(pixels, screen.pixels(seen.b[n].head<3>()));
    }
  }
  for (std::size_t a = 0, stride = 1; a < 3; ++a, stride *= 4) {
    const Eigen::Array4d largest = differences.first[a].cast<double>();
    double across = largest.head<2>().maxCoeff();
    if (screen.is_perspective()) {
      across = 0;
      for (std::size_t n = 0; n < 64; ++n) {
        if (n / stride % 4 < 3)
          across = std::max(across, (image[n + stride] - image[n]).cwiseAbs().maxCoeff());
      }
    }
    e.across[a] = 3 * across;
    e.length[a] = 3 * pixels * largest.head<3>().matrix().norm();
  }
  return e;
}

Extents extents(const Solid& seen, const Screen& screen) {
  return extents(seen, LargestDifferences(seen, seen.b[0]), screen);
}

ImageBox::ImageBox(const Solid& seen, const Screen& screen) {
  Eigen::Array2d low = screen.project(seen.b[0].head<3>()).array(), high = low;
  for (const Point4& b : seen.b) {
    const Eigen::Array2d image = screen.project(b.head<3>()).array();
    low = low.min(image);
    high = high.max(image);
  }
  left = low.x();
  right = high.x();
  top = low.y();
  bottom = high.y();
}

int step_count(double extent, double throttle) {
  return static_cast<int>(std::clamp(std::ceil(extent / throttle), 1.0, static_cast<double>(kMostSteps)));
}

}  // namespace vol::curvilinear
