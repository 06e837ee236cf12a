#include "wavelet/expansion.h"

#include <sstream>

#include "base/rng.h"
#include "kernels.h"
#include "render/wavelet_xray.h"
#include "truth.h"
#include "wavelet/dwt.h"
#include "wavelet/filters.h"

// Line integrals of wavelet expansions: Haar against a walk from voxel to voxel, all of a constant against
// its chord.
namespace vol::stability {
namespace {

using namespace vol::wavelet;

volume::Grid<double> noise(const Dims& dims, double scale, double offset) {
  volume::Grid<double> grid;
  grid.geometry.dims = dims;
  grid.voxels = Buffer<double>(static_cast<std::size_t>(grid.geometry.count()));
  Rng rng(8);
  for (double& v : grid.voxels) v = offset + scale * rng.uniform(-1, 1);
  return grid;
}

Expansion expansion_of(const volume::Grid<double>& grid, const std::string& wavelet, int levels) {
  volume::Volume v;
  v.grid = grid;
  return Expansion(analyze<double>(v, {.wavelet = wavelet, .levels = levels}, volume::value_range(v)),
                   {.depth = 5});
}

/// Integral of the voxels' values along o + t d, t in [begin, end], index coordinates: voxel i is all of
/// [i - 1/2, i + 1/2), as Haar's functions are; along an axis of one sample the field is constant.
struct Walk {
  Real integral = 0, magnitude = 0;
  int crossings = 0;
};
Walk walk(const volume::Grid<double>& f, const Vec3& o, const Vec3& d, double begin, double end) {
  std::vector<Real> cuts{begin, end};
  for (int a = 0; a < 3; ++a) {
    if (d[a] == 0 || f.dims()[static_cast<std::size_t>(a)] == 1) continue;
    for (std::int64_t i = 0; i <= f.dims()[static_cast<std::size_t>(a)]; ++i) {
      const Real t = (static_cast<Real>(i) - 0.5L - static_cast<Real>(o[a])) / static_cast<Real>(d[a]);
      if (t > begin && t < end) cuts.push_back(t);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  Walk result;
  for (std::size_t n = 0; n + 1 < cuts.size(); ++n) {
    const Real middle = (cuts[n] + cuts[n + 1]) / 2;
    std::int64_t at[3];
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      const Real x =
          d[a] == 0 ? static_cast<Real>(o[a]) : static_cast<Real>(o[a]) + middle * static_cast<Real>(d[a]);
      at[a] =
          f.dims()[static_cast<std::size_t>(a)] == 1 ? 0 : static_cast<std::int64_t>(std::floor(x + 0.5L));
      inside = inside && at[a] >= 0 && at[a] < f.dims()[static_cast<std::size_t>(a)];
    }
    if (!inside) continue;
    const Real value = f(at[0], at[1], at[2]);
    result.integral += value * (cuts[n + 1] - cuts[n]);
    result.magnitude += std::abs(value) * (cuts[n + 1] - cuts[n]);
    ++result.crossings;
  }
  return result;
}

struct Line {
  Vec3 origin, direction;
  double begin, end;
};

void haar(Table& table, const std::string& what, const Dims& dims, int levels, double scale, double offset,
          const std::vector<Line>& lines) {
  const auto grid = noise(dims, scale, offset);
  const Expansion expansion = expansion_of(grid, "haar", levels);
  Worst worst;
  const Box3 box = expansion.index_box();
  for (Line line : lines) {
    // Within the field's box, as renderers ask: what a size was extended by lies outside.
    const TrueChord chord = true_chord(box.min, box.size(), {line.origin, line.direction}, line.begin);
    if (chord.length == 0) continue;
    line.begin = chord.entry;
    line.end = std::min(line.end, chord.exit);
    const Walk truth = walk(grid, line.origin, line.direction, line.begin, line.end);
    Real sum = 0;
    for (const Band& band : expansion.bands()) {
      for (const Term& term : band.terms) {
        sum += line_integral(expansion, band, term, line.origin, line.direction, line.begin, line.end);
      }
    }
    // Each band is off by rounding of its coefficients, 3 m filterings, and of its pieces' ends, which lie as
    // far from the origin as the ray does; its functions are 1 in magnitude, 8 times a voxel's at most.
    const double largest = std::abs(offset) + scale, length = line.end - line.begin;
    const double ends = line.origin.norm() + std::max(std::abs(line.begin), std::abs(line.end));
    const double bound = 8.0 * (levels + 1) * largest * kDouble *
                         (16 * (levels + 1) * length + 8 * ends * (2 + truth.crossings));
    worst.add(static_cast<double>(std::abs(sum - truth.integral)) / (largest * length),
              bound / (largest * length));
  }
  table.row(what, "line_integral, haar", "double", worst,
            "8 functions a level: 16 (m+1) roundings, 8 at each voxel's face");
}

std::vector<Line> askew(const Dims& dims, double away, int count = 40) {
  Rng rng(12);
  std::vector<Line> lines;
  for (int n = 0; n < count; ++n) {
    const Vec3 target(rng.uniform(0, double(dims[0] - 1)), rng.uniform(0, double(dims[1] - 1)),
                      rng.uniform(0, double(dims[2] - 1)));
    Vec3 direction(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (n % 4 == 1) direction[n % 3] *= 1e-9;
    direction.normalize();
    lines.push_back({target - away * direction, direction, away - 0.4, away + rng.uniform(0, 20)});
  }
  return lines;
}

/// Along axes: on the planes between voxels (they belong to the upper voxel), and through voxels.
std::vector<Line> aligned(const Dims& dims) {
  std::vector<Line> lines;
  for (int a = 0; a < 3; ++a) {
    for (const double x : {0.5, 1.5, 0.0, 1.0, 0.25}) {
      for (const double sign : {1.0, -1.0}) {
        Vec3 origin(x, x, x);
        origin[a] = sign > 0 ? -3 : double(dims[static_cast<std::size_t>(a)]) + 2;
        lines.push_back({origin, sign * Vec3::Unit(a), 1, double(dims[static_cast<std::size_t>(a)]) + 4});
      }
    }
  }
  return lines;
}

/// A constant: the integral is constant times chord, for every wavelet.
void constants(Table& table) {
  for (const double c : {1.0, 1e30, 1e-30}) {
    Worst worst;
    for (const std::string& name : wavelet_names()) {
      if (!make_wavelet(name).orthonormal) continue;  // truncated: stands for the untruncated functions
      volume::Grid<double> grid = noise({8, 8, 4}, 0, c);
      const Expansion expansion = expansion_of(grid, name, 2);
      const render::WaveletXray xray(expansion);
      const render::RayBox box(expansion.bounds());
      for (const Line& line : askew({8, 8, 4}, 7, 10)) {
        const camera::Ray ray{line.origin, line.direction};
        const auto chord = box.chord(ray, -HUGE_VAL);
        if (!chord) continue;
        std::int64_t terms = 0, pieces = 0;
        const double found = xray.integral(ray, *chord, terms, pieces);
        const Real truth =
            static_cast<Real>(c) * (static_cast<Real>(chord->exit) - static_cast<Real>(chord->entry));
        // Magnitudes of the terms that add up to it; each piece of a term is rounded 64 times at most.
        Real size = 0;
        for (const Band& band : expansion.bands()) {
          for (const Term& term : band.terms)
            size += std::abs(
                line_integral(expansion, band, term, ray.origin, ray.direction, chord->entry, chord->exit));
        }
        worst.add(static_cast<double>(std::abs(found - truth) / std::abs(truth)),
                  256 * kDouble *
                      static_cast<double>((size + std::abs(static_cast<Real>(c)) * 20) / std::abs(truth)));
      }
    }
    std::ostringstream what;
    what << "constant " << c << ", two levels, all orthonormal wavelets";
    table.row(what.str(), "WaveletXray::integral", "double", worst,
              "partition of unity: 256 roundings of the terms' magnitudes and positions");
  }
}

}  // namespace

void expansion(Table& table) {
  haar(table, "askew, one level", {16, 12, 20}, 1, 1, 0, askew({16, 12, 20}, 5));
  haar(table, "askew from 1000 voxels away", {16, 16, 16}, 2, 1, 0, askew({16, 16, 16}, 1000));
  haar(table, "the last level of 16^3", {16, 16, 16}, 4, 1, 0, askew({16, 16, 16}, 5));
  haar(table, "1 x 1 x 4096, level 12", {1, 1, 4096}, 12, 1, 0,
       {{Vec3(0, 0, -1), Vec3(0, 0, 1), 0, 4098},
        {Vec3(-1, 0, 2048), Vec3(1e-3, 0, 1).normalized(), 0, 1500}});
  haar(table, "sizes 2 x 3 x 1", {2, 3, 1}, 1, 1, 0, askew({2, 3, 1}, 2));
  haar(table, "along axes, in voxels and on the planes between", {8, 4, 8}, 2, 1, 0, aligned({8, 4, 8}));
  haar(table, "coefficients of 1e30", {16, 12, 20}, 2, 1e30, 0, askew({16, 12, 20}, 5));
  haar(table, "coefficients of 1e-30", {16, 12, 20}, 2, 1e-30, 0, askew({16, 12, 20}, 5));
  haar(table, "signal 1 on 1e8", {16, 12, 20}, 2, 1, 1e8, askew({16, 12, 20}, 5));
  constants(table);
  table.refusal("pixels that float does not hold", "WaveletXray::draw", "float pixel", [] {
    const Expansion huge = expansion_of(noise({8, 8, 8}, 1, 1e38), "haar", 1);
    render::RenderOptions options;
    options.width = options.height = 4;
    (void)render::WaveletXray(huge).draw({}, options);
  });
  table.refusal("depth 15 of the prototypes", "make_prototypes", "double",
                [] { (void)make_prototypes(make_wavelet("daubechies-4"), 15); });
}

}  // namespace vol::stability
