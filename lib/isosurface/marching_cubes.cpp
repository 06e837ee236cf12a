#include "isosurface/marching_cubes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "isosurface/cell_row.h"
#include "isosurface/cell_surface.h"
#include "isosurface/inside_bits.h"
#include "isosurface/padded_grid.h"

namespace vol::isosurface {
namespace {

using volume::Grid;
using Index = std::uint32_t;
using Word = std::uint64_t;

/// What a row of samples owns: the crossings on its x edges and on the y and z edges that begin at it; and
/// the row of cells above it. First counts, then positions in the mesh.
struct RowPlace {
  Index vertex[3] = {0, 0, 0};  // by edge axis
  Index point = 0;              // within cells
  std::uint64_t triangle = 0;
};

/// A decision kept from counting to making: the case's number, and 1 + kind + 2 diagonal of a tube above.
using Decision = std::uint32_t;
Decision packed(const CellDecision& d) {
  const auto tube =
      d.tube.kind == TubeKind::none ? 0u : 1u + (d.tube.kind == TubeKind::outside) + 2u * d.tube.diagonal;
  return static_cast<Decision>(d.number) | tube << 16;
}
CellDecision unpacked(Decision d, int corners) {
  CellDecision result{corners, static_cast<int>(d & 0xffff), {}};
  if (const unsigned tube = d >> 16; tube != 0) {
    result.tube.kind = ((tube - 1) & 1) != 0 ? TubeKind::outside : TubeKind::inside;
    result.tube.diagonal = static_cast<std::uint8_t>((tube - 1) >> 1);
  }
  return result;
}

template <class T>
class Mesher {
 public:
  Mesher(const Grid<T>& grid, double isovalue, const Vec3& shift, const MarchingCubesOptions& options)
      : grid_(grid, options.close),
        isovalue_(isovalue),
        options_(options),
        cases_(CellCases::all()),
        bits_(inside_bits(grid.voxels.data(), grid.dims(), isovalue, grid_.pad)),
        rows_(bits_.dims[1] * bits_.dims[2]),
        // About as many rows a chunk as make 2^14 samples.
        grain_(std::max<std::int64_t>(1, (1 << 14) / bits_.dims[0])),
        place_(static_cast<std::size_t>(rows_) + 1),
        decisions_(static_cast<std::size_t>((rows_ + grain_ - 1) / grain_)) {
    const auto& g = grid.geometry;
    for (int a = 0; a < 3; ++a) to_world_.col(a) = g.direction.col(a) * g.spacing[a];
    origin_ = g.origin + to_world_ * (shift - Vec3::Constant(grid_.pad));
    to_world_gradient_ = g.world_to_index_matrix().transpose();
    left_handed_ = g.direction.determinant() < 0;
  }

  Isosurface run() {
    Isosurface result;
    result.counts = count();
    place();
    const RowPlace& end = place_.back();
    result.mesh.positions = Buffer<std::array<double, 3>>(vertices_);
    if (options_.normals) result.mesh.normals = Buffer<std::array<float, 3>>(vertices_);
    result.mesh.triangles = Buffer<std::array<Index, 3>>(end.triangle);
    mesh_ = &result.mesh;
    parallel_for(0, rows_, grain_, [&](std::int64_t begin, std::int64_t end_row) {
      const Decision* decision = decisions_[static_cast<std::size_t>(begin / grain_)].data();
      for (std::int64_t r = begin; r < end_row; ++r) {
        if (is_plain(r)) continue;
        make_vertices(r);
        if (has_cells(r)) make_triangles(r, decision);
      }
    });
    return result;
  }

 private:
  using RowKind = InsideBits::Row;

  [[nodiscard]] bool has_cells(std::int64_t r) const {
    return r % bits_.dims[1] + 1 < bits_.dims[1] && r / bits_.dims[1] + 1 < bits_.dims[2];
  }
  /// Nothing crosses a row all of whose neighbours above are of its own kind.
  [[nodiscard]] bool is_plain(std::int64_t r) const {
    const RowKind kind = bits_.rows[r];
    if (kind == RowKind::mixed) return false;
    const bool y = r % bits_.dims[1] + 1 < bits_.dims[1];
    const bool z = r / bits_.dims[1] + 1 < bits_.dims[2];
    return (!y || bits_.rows[r + 1] == kind) && (!z || bits_.rows[r + bits_.dims[1]] == kind) &&
           (!y || !z || bits_.rows[r + bits_.dims[1] + 1] == kind);
  }
  /// The crossings that a row owns, by axis of the edge: f(axis, word number, bits).
  template <class F>
  void for_crossings(std::int64_t r, const F& f) const {
    const Word* row = bits_.row(r);
    for (std::int64_t w = 0; w < bits_.words; ++w) f(0, w, x_crossings(row, w, bits_.words, bits_.dims[0]));
    if (r % bits_.dims[1] + 1 < bits_.dims[1]) {
      const Word* next = bits_.row(r + 1);
      for (std::int64_t w = 0; w < bits_.words; ++w) f(1, w, row[w] ^ next[w]);
    }
    if (r / bits_.dims[1] + 1 < bits_.dims[2]) {
      const Word* next = bits_.row(r + bits_.dims[1]);
      for (std::int64_t w = 0; w < bits_.words; ++w) f(2, w, row[w] ^ next[w]);
    }
  }

  [[nodiscard]] CellValues values(std::int64_t i, std::int64_t j, std::int64_t k) const {
    CellValues cell;
    cell.isovalue = isovalue_;
    for (int c = 0; c < 8; ++c) cell.value[c] = grid_.value(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
    return cell;
  }
  [[nodiscard]] bool touches_padding(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return grid_.is_beyond(i, j, k) || grid_.is_beyond(i + 1, j + 1, k + 1);
  }
  [[nodiscard]] CellDecision decide_at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return decide(values(i, j, k), touches_padding(i, j, k));
  }

  MarchingCubesCounts count() {
    const auto total = parallel_reduce<MarchingCubesCounts>(
        0, rows_, grain_,
        [&](std::int64_t begin, std::int64_t end) {
          MarchingCubesCounts counts;
          auto& decisions = decisions_[static_cast<std::size_t>(begin / grain_)];
          for (std::int64_t r = begin; r < end; ++r) {
            place_[static_cast<std::size_t>(r)] = is_plain(r) ? RowPlace{} : count_row(r, decisions, counts);
          }
          return counts;
        },
        [](MarchingCubesCounts& sum, const MarchingCubesCounts& part) {
          sum.active_cells += part.active_cells;
          sum.ambiguous_cells += part.ambiguous_cells;
          sum.tubes += part.tubes;
        });
    return total;
  }

  RowPlace count_row(std::int64_t r, std::vector<Decision>& decisions, MarchingCubesCounts& counts) const {
    RowPlace row;
    for_crossings(r, [&](int axis, std::int64_t, Word cut) {
      row.vertex[axis] += static_cast<Index>(std::popcount(cut));
    });
    if (!has_cells(r)) return row;
    const std::int64_t j = r % bits_.dims[1];
    const std::int64_t k = r / bits_.dims[1];
    CellRow(bits_, r).for_active([&](std::int64_t i, int corners) {
      ++counts.active_cells;
      if (cases_.is_decided(corners)) {
        row.triangle += cases_[cases_.number(corners, 0)].triangle_count;
        return;
      }
      const CellDecision decision = decide_at(i, j, k);
      const CellSize size = surface_size(cases_[decision.number], decision);
      row.triangle += static_cast<std::uint64_t>(size.triangles);
      row.point += static_cast<Index>(size.points);
      ++counts.ambiguous_cells;
      counts.tubes += decision.tube.kind != TubeKind::none;
      decisions.push_back(packed(decision));
    });
    return row;
  }

  /// From counts to places: vertices on edges row after row, then those within cells.
  void place() {
    std::uint64_t vertex = 0;
    std::uint64_t point = 0;
    std::uint64_t triangle = 0;
    for (auto& row : place_) {
      for (Index& v : row.vertex) {
        const Index n = v;
        v = static_cast<Index>(vertex);
        vertex += n;
      }
      const Index n = row.point;
      row.point = static_cast<Index>(point);
      point += n;
      const std::uint64_t m = row.triangle;
      row.triangle = triangle;
      triangle += m;
    }
    vertices_ = vertex + point;
    if (vertices_ > std::numeric_limits<Index>::max()) {
      throw Error("the isosurface has " + std::to_string(vertices_) +
                  " vertices, over 2^32 - 1: take a part of the volume");
    }
    for (auto& row : place_) row.point += static_cast<Index>(vertex);
  }

  void make_vertices(std::int64_t r) {
    const std::int64_t j = r % bits_.dims[1];
    const std::int64_t k = r / bits_.dims[1];
    Index next[3];
    std::copy_n(place_[static_cast<std::size_t>(r)].vertex, 3, next);
    for_crossings(r, [&](int axis, std::int64_t w, Word cut) {
      for (; cut != 0; cut &= cut - 1) make_vertex(next[axis]++, axis, 64 * w + std::countr_zero(cut), j, k);
    });
  }

  void make_vertex(Index v, int axis, std::int64_t i, std::int64_t j, std::int64_t k) {
    std::int64_t to[3] = {i, j, k};
    ++to[axis];
    const double first = grid_.value(i, j, k);
    const double second = grid_.value(to[0], to[1], to[2]);
    const double t = crossing(first, second, isovalue_);
    double p[3] = {static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
    p[axis] += t;
    put(v, p);
    if (!options_.normals) return;
    double normal[3] = {0, 0, 0};
    if (first == kOutside || second == kOutside) {
      // On a closed border, out of the volume: a covector in index space, like the gradients below.
      normal[axis] = first == kOutside ? -1 : 1;
    } else {
      const std::int64_t pad = grid_.pad;
      grid_.add_gradient(i - pad, j - pad, k - pad, t - 1, normal);
      grid_.add_gradient(to[0] - pad, to[1] - pad, to[2] - pad, -t, normal);
    }
    put_normal(v, normal);
  }

  /// A vertex by padded index coordinates.
  void put(Index v, const double* p) {
    auto& to = mesh_->positions[v];
    for (int a = 0; a < 3; ++a) {
      to[a] = origin_[a] + (to_world_(a, 0) * p[0] + to_world_(a, 1) * p[1] + to_world_(a, 2) * p[2]);
    }
  }
  /// A normal by its direction as a covector in index space; 0 for 0.
  void put_normal(Index v, const double* n) {
    const auto world = [&](double* w) {
      double square = 0;
      for (int a = 0; a < 3; ++a) {
        w[a] = to_world_gradient_(a, 0) * n[0] + to_world_gradient_(a, 1) * n[1] +
               to_world_gradient_(a, 2) * n[2];
        square += w[a] * w[a];
      }
      return square;
    };
    double w[3];
    double square = world(w);
    if (!(square > 1e-200 && square < 1e200)) {  // of gradients of 1e-200 or 1e200 that is 0 or infinite
      double largest = 0;
      for (int a = 0; a < 3; ++a) largest = std::max(largest, std::abs(w[a]));
      if (!(largest > 0 && largest <= std::numeric_limits<double>::max())) {
        mesh_->normals[v] = {0, 0, 0};
        return;
      }
      square = 0;
      for (double& x : w) {
        x /= largest;
        square += x * x;
      }
    }
    const double scale = 1 / std::sqrt(square);
    mesh_->normals[v] = {static_cast<float>(w[0] * scale), static_cast<float>(w[1] * scale),
                         static_cast<float>(w[2] * scale)};
  }

  void make_triangles(std::int64_t r, const Decision*& decision) {
    const std::int64_t j = r % bits_.dims[1];
    const std::int64_t k = r / bits_.dims[1];
    const RowPlace& p00 = place_[static_cast<std::size_t>(r)];
    const RowPlace& p10 = place_[static_cast<std::size_t>(r + 1)];
    const RowPlace& p01 = place_[static_cast<std::size_t>(r + bits_.dims[1])];
    const RowPlace& p11 = place_[static_cast<std::size_t>(r + bits_.dims[1] + 1)];
    // The next vertex on each of the edges that cross this row of cells; an edge at i + 1 comes after that at
    // i.
    Index x[4] = {p00.vertex[0], p10.vertex[0], p01.vertex[0], p11.vertex[0]};
    Index y[2] = {p00.vertex[1], p01.vertex[1]};
    Index z[2] = {p00.vertex[2], p10.vertex[2]};
    Index point = p00.point;
    std::array<Index, 3>* out = mesh_->triangles.data() + p00.triangle;
    const int second = left_handed_ ? 2 : 1;
    CellSurface surface;
    CellRow(bits_, r).for_active([&](std::int64_t i, int corners) {
      const unsigned cut = cases_.cut_edges(corners);
      const auto is_cut = [&](int e) { return cut >> e & 1u; };
      Index id[24] = {x[0],
                      x[1],
                      x[2],
                      x[3],
                      y[0],
                      y[1],
                      y[0] + is_cut(4),
                      y[1] + is_cut(5),
                      z[0],
                      z[0] + is_cut(8),
                      z[1],
                      z[1] + is_cut(10)};
      const auto emit = [&](const auto& triangles, int n) {
        for (int t = 0; t < n; ++t) {
          const auto& c = triangles[static_cast<std::size_t>(t)];
          *out++ = {id[c[0]], id[c[second]], id[c[3 - second]]};
        }
      };
      if (cases_.is_decided(corners)) {
        const CellCase& cell = cases_[cases_.number(corners, 0)];
        emit(cell.triangles, cell.triangle_count);
      } else {
        const CellDecision d = unpacked(*decision++, corners);
        const CellCase& cell = cases_[d.number];
        if (d.tube.kind == TubeKind::none && cell.centre_count == 0) {
          emit(cell.triangles, cell.triangle_count);
        } else {
          make_surface(values(i, j, k), d, surface);
          for (int n = 0; n < surface.point_count; ++n) {
            id[12 + n] = point;
            make_point(point++, i, j, k, surface.points[static_cast<std::size_t>(n)]);
          }
          emit(surface.triangles, surface.triangle_count);
        }
      }
      for (int e = 0; e < 4; ++e) x[e] += is_cut(e);
      for (int e = 0; e < 2; ++e) y[e] += is_cut(4 + e);
      z[0] += is_cut(8);
      z[1] += is_cut(10);
    });
  }

  /// A vertex within a cell; its normal by interpolation of the samples' central differences.
  void make_point(Index v, std::int64_t i, std::int64_t j, std::int64_t k, const Vec3& p) {
    const double at[3] = {static_cast<double>(i) + p[0], static_cast<double>(j) + p[1],
                          static_cast<double>(k) + p[2]};
    put(v, at);
    if (!options_.normals) return;
    double normal[3] = {0, 0, 0};
    const std::int64_t pad = grid_.pad;
    for (int c = 0; c < 8; ++c) {
      const std::int64_t corner[3] = {i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)};
      if (grid_.is_beyond(corner[0], corner[1], corner[2])) continue;
      double weight = -1;
      for (int a = 0; a < 3; ++a) weight *= (c >> a & 1) != 0 ? p[a] : 1 - p[a];
      grid_.add_gradient(corner[0] - pad, corner[1] - pad, corner[2] - pad, weight, normal);
    }
    put_normal(v, normal);
  }

  PaddedGrid<T> grid_;
  double isovalue_;
  MarchingCubesOptions options_;
  const CellCases& cases_;
  InsideBits bits_;
  std::int64_t rows_;
  std::int64_t grain_;
  Buffer<RowPlace> place_;
  std::vector<std::vector<Decision>> decisions_;  // of the ambiguous cells, by chunk of rows
  std::uint64_t vertices_ = 0;
  Vec3 origin_;
  Mat3 to_world_;
  Mat3 to_world_gradient_;
  bool left_handed_ = false;
  mesh::TriangleMesh* mesh_ = nullptr;
};

/// Refuses rows whose places and bits do not fit beside the voxels, before any are made.
template <class T>
void require_memory(const Grid<T>& grid, const MarchingCubesOptions& options) {
  const std::int64_t pad = options.close ? 2 : 0;
  std::int64_t dims[3];
  bool thin = false;  // axes of one sample are made two, in a copy
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t n = grid.dims()[a];
    thin = thin || n == 1;
    dims[a] = std::max<std::int64_t>(n, 2) + pad;
  }
  // In double, for lengths are anything: what is over 2^63 is over any limit.
  const double words = std::ceil(static_cast<double>(dims[0]) / 64);
  const double row = 8 * words + sizeof(RowPlace) + sizeof(InsideBits::Row);
  const double rows = static_cast<double>(dims[1]) * static_cast<double>(dims[2]);
  const double samples = rows * static_cast<double>(dims[0]);
  const double copies =
      (thin ? samples * sizeof(T) : 0) + (std::is_same_v<T, volume::half> ? 4 * samples : 0);
  const double voxels = static_cast<double>(grid.voxels.size()) * sizeof(T);
  const double needed = rows * row + copies + voxels;
  if (needed <= static_cast<double>(options.memory_limit)) return;
  throw Error("an isosurface of a volume of " + std::to_string(dims[1]) + " x " + std::to_string(dims[2]) +
              " rows along x takes " + std::to_string(static_cast<std::int64_t>(std::min(needed, 9e18))) +
              " bytes beside its mesh, more than the " + std::to_string(options.memory_limit) +
              " of memory there are: turn its longest axis to x (vol-convert --transpose)");
}

}  // namespace

Isosurface marching_cubes(const volume::Volume& volume, double isovalue,
                          const MarchingCubesOptions& options) {
  if (!std::isfinite(isovalue)) throw Error("an isovalue must be finite");
  return volume::visit(volume, [&]<class T>(const Grid<T>& grid) {
    const Dims& dims = grid.dims();
    Vec3 shift = Vec3::Zero();
    for (int a = 0; a < 3; ++a) shift[a] = dims[a] == 1 ? -0.5 : 0;
    require_memory(grid, options);
    Isosurface result = shift.isZero() ? Mesher<T>(grid, isovalue, shift, options).run()
                                       : Mesher<T>(thickened(grid), isovalue, shift, options).run();
    result.counts.cells = 1;
    for (const auto n : dims) result.counts.cells *= std::max<std::int64_t>(1, n - 1);
    return result;
  });
}

}  // namespace vol::isosurface
