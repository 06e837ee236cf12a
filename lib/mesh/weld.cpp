#include "mesh/weld.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/vec.h"

namespace vol::mesh {
namespace {

using Index = std::uint32_t;
using Place = std::array<double, 3>;
constexpr Index kNone = std::numeric_limits<Index>::max();

std::uint64_t hash(const Place& p) {
  std::uint64_t h = 0;
  for (const double x : p) {
    h = (h ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15u;  // + 0.0: -0 becomes 0
    h ^= h >> 29;
  }
  return h;
}

struct Entry {
  std::uint32_t key;  // of the place
  Index vertex;
};

/// The vertices in buckets by their place's hash, in order within each: tables that fit a cache, filled by
/// any thread.
struct Buckets {
  static constexpr std::size_t kCount = 256;
  Buffer<Entry> entries;
  std::array<std::size_t, kCount + 1> begin{};

  explicit Buckets(const Buffer<Place>& positions) : entries(positions.size()) {
    constexpr std::int64_t kChunk = 1 << 15;
    const auto n = static_cast<std::int64_t>(positions.size());
    std::vector<std::array<std::size_t, kCount>> next(static_cast<std::size_t>((n + kChunk - 1) / kChunk));
    Buffer<std::uint64_t> hashes(positions.size());
    parallel_for(0, n, kChunk, [&](std::int64_t from, std::int64_t to) {
      auto& counts = next[static_cast<std::size_t>(from / kChunk)];
      counts.fill(0);
      for (auto v = static_cast<std::size_t>(from); v < static_cast<std::size_t>(to); ++v) {
        hashes[v] = hash(positions[v]);
        ++counts[hashes[v] >> 56];
      }
    });
    std::size_t total = 0;
    for (std::size_t bucket = 0; bucket < kCount; ++bucket) {
      begin[bucket] = total;
      for (auto& chunk : next) {
        const std::size_t count = chunk[bucket];
        chunk[bucket] = total;
        total += count;
      }
    }
    begin[kCount] = total;
    parallel_for(0, n, kChunk, [&](std::int64_t from, std::int64_t to) {
      auto& place = next[static_cast<std::size_t>(from / kChunk)];
      for (auto v = static_cast<std::size_t>(from); v < static_cast<std::size_t>(to); ++v) {
        entries[place[hashes[v] >> 56]++] = {static_cast<std::uint32_t>(hashes[v] >> 16),
                                             static_cast<Index>(v)};
      }
    });
  }
};

/// For each vertex the first at its place.
Buffer<Index> first_at_place(const Buffer<Place>& positions) {
  const Buckets buckets(positions);
  Buffer<Index> first(positions.size());
  parallel_for(0, Buckets::kCount, 1, [&](std::int64_t from, std::int64_t to) {
    for (auto bucket = static_cast<std::size_t>(from); bucket < static_cast<std::size_t>(to); ++bucket) {
      const std::size_t begin = buckets.begin[bucket];
      const std::size_t end = buckets.begin[bucket + 1];
      std::size_t size = 16;
      while (size < 2 * (end - begin)) size *= 2;
      std::vector<Index> table(size, kNone);  // entry numbers, from begin
      for (std::size_t n = begin; n < end; ++n) {
        const Entry& entry = buckets.entries[n];
        std::size_t slot = entry.key & (size - 1);
        while (table[slot] != kNone) {
          const Entry& other = buckets.entries[begin + table[slot]];
          if (other.key == entry.key && positions[other.vertex] == positions[entry.vertex]) break;
          slot = (slot + 1) & (size - 1);
        }
        if (table[slot] == kNone) table[slot] = static_cast<Index>(n - begin);
        first[entry.vertex] = buckets.entries[begin + table[slot]].vertex;
      }
    }
  });
  return first;
}

bool is_flat(const TriangleMesh& mesh, const std::array<Index, 3>& t) {
  const auto at = [&](int i) { return Eigen::Map<const Vec3>(mesh.positions[t[i]].data()); };
  Vec3 u = at(1) - at(0);
  Vec3 v = at(2) - at(0);
  // Products of edges of 1e-90 are still normal numbers, those of 1e-200 and squares of the first are not.
  const double size = std::max(u.cwiseAbs().maxCoeff(), v.cwiseAbs().maxCoeff());
  if (size > 0) {
    u /= size;
    v /= size;
  }
  return u.cross(v).isZero(0);
}

/// In absolute value; infinity where one is NaN.
double largest_coordinate(const TriangleMesh& mesh) {
  double largest = 0;
  for (const auto& p : mesh.positions) {
    for (const double x : p) {
      if (!(std::abs(x) <= largest))
        largest = std::isnan(x) ? std::numeric_limits<double>::infinity() : std::abs(x);
    }
  }
  return largest;
}

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

}  // namespace

WeldCounts weld(TriangleMesh& mesh) {
  WeldCounts counts;
  const Buffer<Index> first = first_at_place(mesh.positions);
  const std::size_t vertices = mesh.positions.size();
  for (std::size_t v = 0; v < vertices; ++v) counts.vertices_merged += first[v] != v;
  counts.flat_triangles = parallel_reduce<std::int64_t>(
      0, static_cast<std::int64_t>(mesh.triangles.size()), 1 << 15,
      [&](std::int64_t begin, std::int64_t end) {
        std::int64_t flat = 0;
        for (std::int64_t n = begin; n < end; ++n) {
          const auto& t = mesh.triangles[static_cast<std::size_t>(n)];
          const bool collapsed =
              first[t[0]] == first[t[1]] || first[t[1]] == first[t[2]] || first[t[2]] == first[t[0]];
          flat += !collapsed && is_flat(mesh, t);
        }
        return flat;
      },
      [](std::int64_t& total, std::int64_t part) { total += part; });
  if (counts.vertices_merged == 0) return counts;

  std::size_t kept = 0;
  std::vector<bool> used(vertices, false);
  for (const auto& t : mesh.triangles) {
    const std::array<Index, 3> welded{first[t[0]], first[t[1]], first[t[2]]};
    if (welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0]) continue;
    for (const Index v : welded) used[v] = true;
    mesh.triangles[kept++] = welded;
  }
  counts.triangles_dropped = static_cast<std::int64_t>(mesh.triangles.size() - kept);
  mesh.triangles.resize(kept);

  std::vector<Index> number(vertices, kNone);
  Index next = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    if (!used[v]) {
      counts.vertices_unused += first[v] == v;
      continue;
    }
    number[v] = next;
    mesh.positions[next] = mesh.positions[v];
    if (!mesh.normals.empty()) mesh.normals[next] = mesh.normals[v];
    ++next;
  }
  mesh.positions.resize(next);
  if (!mesh.normals.empty()) mesh.normals.resize(next);
  for (auto& t : mesh.triangles) {
    for (Index& v : t) v = number[v];
  }
  return counts;
}

void round_to_float(TriangleMesh& mesh, double finest) {
  const double largest = largest_coordinate(mesh);
  constexpr double kMost = std::numeric_limits<float>::max();
  const auto at = static_cast<float>(std::min(largest, kMost));
  const double apart =
      static_cast<double>(at) - static_cast<double>(std::nextafter(at, at > 0 ? 0.0F : 1.0F));
  if (!(largest <= kMost) || !(std::abs(apart) <= 1e-3 * finest)) {
    throw Error("f32 is too coarse for positions up to " + short_text(largest) + " at a spacing of " +
                short_text(finest) + ": take --type f64, into .ply or .obj");
  }
  for (auto& p : mesh.positions) {
    for (double& x : p) x = static_cast<double>(static_cast<float>(x));
  }
}

void require_finite(const TriangleMesh& mesh) {
  if (!std::isfinite(largest_coordinate(mesh))) {
    throw Error("the mesh has positions that are not finite: the volume's spacing or origin is too large");
  }
}

}  // namespace vol::mesh
