#include "fourier/models.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.h"
#include "fourier/canny.h"

namespace vol::fourier {
namespace {

/// What a voxel counts: g(value, i, j, k) for every voxel.
template <class G>
RowSource each_voxel(const volume::Volume& volume, G g) {
  return volume::visit(volume, [&g](const auto& grid) -> RowSource {
    return [&grid, g](std::int64_t j, std::int64_t k, std::span<double> row) {
      const auto* from = &grid(0, j, k);
      for (std::size_t i = 0; i < row.size(); ++i) {
        row[i] = g(static_cast<double>(from[i]), static_cast<std::int64_t>(i), j, k);
      }
    };
  });
}

/// Difference quotient along one axis, in steps of the grid.
template <class Grid>
double slope(const Grid& grid, std::array<std::int64_t, 3> at, int axis) {
  const std::int64_t n = grid.dims()[axis];
  if (n == 1) return 0;
  auto lo = at, hi = at;
  lo[axis] = std::max<std::int64_t>(0, at[axis] - 1);
  hi[axis] = std::min(n - 1, at[axis] + 1);
  return (static_cast<double>(grid(hi[0], hi[1], hi[2])) - static_cast<double>(grid(lo[0], lo[1], lo[2]))) /
         static_cast<double>(hi[axis] - lo[axis]);
}

std::string axis_name(const char* of, int axis) {
  return std::string("f ") + of + "xyz"[axis];
}

}  // namespace

Model plain_model(const volume::Volume& volume) {
  return {"plain", {"f"}, {each_voxel(volume, [](double f, auto...) { return f; })}};
}

Model depth_cue_model(const volume::Volume& volume) {
  Model model = plain_model(volume);
  model.name = "depth-cue";
  const volume::GridGeometry g = volume.geometry();
  const Vec3 centre = g.centre();
  // The diagonal of a box with oblique axes is its longest one.
  double diagonal = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const Vec3 signs(1, corner & 1 ? -1 : 1, corner & 2 ? -1 : 1);
    diagonal = std::max(diagonal, (g.direction * g.edge_lengths().cwiseProduct(signs)).norm());
  }
  for (int axis = 0; axis < 3; ++axis) {
    model.spectra.push_back(axis_name("D", axis));
    model.sources.push_back(each_voxel(volume, [=](double f, std::int64_t i, std::int64_t j, std::int64_t k) {
      const Vec3 p =
          g.index_to_world(Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)));
      return f * (p[axis] - centre[axis]) / (0.5 * diagonal);
    }));
  }
  return model;
}

Model directional_model(const volume::Volume& volume) {
  Model model = plain_model(volume);
  model.name = "directional";
  const Mat3 to_world = volume.geometry().world_to_index_matrix().transpose();  // gradients transform so
  for (int axis = 0; axis < 3; ++axis) {
    model.spectra.push_back(axis_name("N", axis));
    model.sources.push_back(volume::visit(volume, [&](const auto& grid) {
      return each_voxel(
          volume, [&grid, to_world, axis](double f, std::int64_t i, std::int64_t j, std::int64_t k) {
            const Vec3 gradient = to_world * Vec3(slope(grid, {i, j, k}, 0), slope(grid, {i, j, k}, 1),
                                                  slope(grid, {i, j, k}, 2));
            const double length = gradient.stableNorm();
            return length > 0 ? -f * gradient[axis] / length : 0.0;
          });
    }));
  }
  return model;
}

Model bezier_model(const volume::Volume& volume, int n, const volume::Range& range) {
  if (n < 1 || n > transfer::kMostControlPoints) {
    throw Error("1 to " + std::to_string(transfer::kMostControlPoints) +
                " control points are possible, not " + std::to_string(n));
  }
  if (!(range.max > range.min) || !std::isfinite(range.max - range.min)) {
    throw Error(
        "control points need a range of values with an extent; the volume is constant, or give --range");
  }
  Model model{"bezier", {}, {}};
  double binomial = 1;
  for (int i = 0; i < n; ++i) {
    model.spectra.push_back("f B" + std::to_string(i));
    model.sources.push_back(each_voxel(volume, [=](double f, auto...) {
      const double v = std::clamp((f - range.min) / (range.max - range.min), 0.0, 1.0);
      return v * binomial * std::pow(1 - v, n - 1 - i) * std::pow(v, i);
    }));
    binomial *= static_cast<double>(n - 1 - i) / (i + 1);
  }
  return model;
}

Model bands_model(const volume::Volume& volume, const std::vector<Band>& bands, bool edges) {
  Model model{"bands", {}, {}};
  const double largest = volume::value_range(volume).max;
  for (const Band& band : bands) {
    if (!(band.lo <= band.hi)) throw Error("a band ends below its beginning");
    model.spectra.push_back("band " + std::to_string(model.spectra.size()));
    model.sources.push_back(each_voxel(volume, [=](double f, auto...) {
      return f >= band.lo && (f < band.hi || (f == largest && band.hi == largest)) ? f : 0.0;
    }));
  }
  if (edges) {
    const auto found = std::make_shared<Buffer<std::uint8_t>>(canny_edges(volume));
    const Dims n = volume.geometry().dims;
    model.spectra.emplace_back("edges");
    model.sources.push_back([found, n](std::int64_t j, std::int64_t k, std::span<double> row) {
      for (std::size_t i = 0; i < row.size(); ++i)
        row[i] = (*found)[i + static_cast<std::size_t>(n[0] * (j + n[1] * k))];
    });
  }
  if (model.spectra.empty()) throw Error("neither bands nor edges");
  return model;
}

std::vector<double> depth_cue_weights(const camera::Camera& camera, double strength) {
  const Vec3 v = -0.5 * strength * camera.direction();
  return {0.5 * strength, v.x(), v.y(), v.z()};
}

std::vector<double> directional_weights(const Vec3& light) {
  if (!(light.cwiseAbs().maxCoeff() > 0) || !light.allFinite()) throw Error("--light is not a direction");
  const Vec3 l =
      0.5 * (light / light.cwiseAbs().maxCoeff()).normalized();  // squares neither overflow nor vanish
  return {0.5, l.x(), l.y(), l.z()};
}

}  // namespace vol::fourier
