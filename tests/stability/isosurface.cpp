#include "isosurface/marching_cubes.h"

#include "kernels.h"
#include "mesh/measures.h"
#include "truth.h"

// Meshes: topology by counts, vertices by the field that they are to lie on.
namespace vol::stability {
namespace {

volume::Grid<double> grid(const Dims& dims, const Vec3& spacing, const auto& f) {
  volume::Grid<double> result;
  result.geometry.dims = dims;
  result.geometry.spacing = spacing;
  result.voxels = Buffer<double>(static_cast<std::size_t>(result.geometry.count()));
  std::size_t n = 0;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) result.voxels[n++] = f(i, j, k);
    }
  }
  return result;
}

/// The trilinear field less the isovalue at a vertex, and the sum of the magnitudes it is made of.
struct AtVertex {
  Real value = 0, magnitude = 0;
};
AtVertex interpolated(const volume::Grid<double>& f, const std::array<double, 3>& p, double isovalue) {
  std::int64_t cell[3];
  Real u[3];
  for (std::size_t a = 0; a < 3; ++a) {
    const auto n = f.dims()[a];
    const Real x = (static_cast<Real>(p[a]) - static_cast<Real>(f.geometry.origin[static_cast<int>(a)])) /
                   static_cast<Real>(f.geometry.spacing[static_cast<int>(a)]);
    cell[a] = n == 1 ? 0 : std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x)), 0, n - 2);
    u[a] = n == 1 ? 0 : std::clamp<Real>(x - static_cast<Real>(cell[a]), 0, 1);
  }
  AtVertex result;
  for (int corner = 0; corner < 8; ++corner) {
    Real weight = 1;
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) {
      const bool upper = (corner >> a & 1) != 0;
      weight *= upper ? u[a] : 1 - u[a];
      at[a] = std::min(cell[a] + (upper ? 1 : 0), f.dims()[static_cast<std::size_t>(a)] - 1);
    }
    const Real v = static_cast<Real>(f(at[0], at[1], at[2])) - static_cast<Real>(isovalue);
    result.value += weight * v;
    result.magnitude = std::max(result.magnitude, std::abs(v));
  }
  return result;
}

/// \param euler  of the closed surface
void surface(Table& table, const std::string& what, const volume::Grid<double>& f, double isovalue,
             std::int64_t euler, std::int64_t components) {
  volume::Volume volume;
  volume.grid = f;
  isosurface::MarchingCubesOptions options;
  options.close = true;
  const auto found = isosurface::marching_cubes(volume, isovalue, options);
  const auto t = mesh::topology(found.mesh);
  const double wrong =
      static_cast<double>(std::abs(t.euler - euler) + std::abs(t.components - components) + t.boundary_edges +
                          t.non_manifold_edges + t.misoriented_edges + t.non_manifold_vertices);
  table.row(what, "marching_cubes, topology", "double", wrong, 0,
            "Euler characteristic, components; closed, oriented, manifold");
  options.close = false;
  const auto open = isosurface::marching_cubes(volume, isovalue, options);
  Worst on;
  for (const auto& p : open.mesh.positions) {
    const AtVertex at = interpolated(f, p, isovalue);
    // Position and share of the way are rounded; so is the isovalue's difference from each sample.
    double place = 0;
    for (std::size_t a = 0; a < 3; ++a) place += std::abs(p[a]) / f.geometry.spacing[static_cast<int>(a)];
    on.add(static_cast<double>(std::abs(at.value) / at.magnitude), 8 * kDouble * (2 + place));
  }
  if (on.count() > 0)
    table.row(what, "marching_cubes, vertices", "double", on,
              "8 roundings of a vertex's coordinates, times the largest slope");
}

}  // namespace

void isosurface(Table& table) {
  const auto ball = [](const Dims& n, double scale, double offset) {
    return [=](std::int64_t i, std::int64_t j, std::int64_t k) {
      double r = 0;
      const double x[3] = {double(i), double(j), double(k)};
      for (std::size_t a = 0; a < 3; ++a)
        r += std::pow((x[a] - 0.5 * double(n[a] - 1)) / (0.5 * double(n[a] - 1) + 1e-9), 2);
      return offset + scale * (0.7 - std::sqrt(r));
    };
  };
  const Dims n{17, 13, 19};
  surface(table, "ball, primes 17 x 13 x 19", grid(n, {1, 1, 1}, ball(n, 1, 0)), 0, 2, 1);
  surface(table, "values of 1e30", grid(n, {1, 1, 1}, ball(n, 1e30, 0)), 0, 2, 1);
  surface(table, "values of 1e-30", grid(n, {1, 1, 1}, ball(n, 1e-30, 0)), 0, 2, 1);
  surface(table, "signal 1 on 1e8", grid(n, {1, 1, 1}, ball(n, 1, 1e8)), 1e8, 2, 1);
  surface(table, "spacing ratio 1e4", grid(n, {1e-2, 1, 100}, ball(n, 1, 0)), 0, 2, 1);
  const auto all = [](std::int64_t, std::int64_t, std::int64_t) { return 1.0; };
  for (const Dims& dims : {Dims{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {2, 3, 1}, {1, 1, 4096}}) {
    const std::string size =
        std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " + std::to_string(dims[2]);
    surface(table, "all inside, closed: " + size, grid(dims, {1, 1, 1}, all), 0.5, 2, 1);
    surface(table, "all at the isovalue, closed: " + size, grid(dims, {1, 1, 1}, all), 1, 2, 1);
    surface(table, "all outside: " + size, grid(dims, {1, 1, 1}, all), 1.5, 0, 0);
  }
  surface(
      table, "every other sample of 1 x 1 x 4096",
      grid({1, 1, 4096}, {1, 1, 1}, [](std::int64_t, std::int64_t, std::int64_t k) { return double(k % 2); }),
      0.5, 2 * 2048, 2048);
  // One corner of a cell a tiny bit inside, then one that equals the isovalue: a disk each, closed to a ball.
  for (const double inside : {1e-300, 0.0}) {
    surface(
        table, inside > 0 ? "one corner 1e-300 inside" : "one corner at the isovalue",
        grid({2, 2, 2}, {1, 1, 1},
             [=](std::int64_t i, std::int64_t j, std::int64_t k) { return i + j + k == 0 ? inside : -1.0; }),
        0, 2, 1);
  }
  volume::Volume volume;
  volume.grid = grid({2, 2, 2}, {1, 1, 1}, all);
  table.refusal("an isovalue that is not finite", "marching_cubes", "double",
                [&] { (void)isosurface::marching_cubes(volume, std::nan("")); });
}

}  // namespace vol::stability
