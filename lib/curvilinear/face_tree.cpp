#include "curvilinear/face_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace vol::curvilinear {
namespace {

constexpr std::size_t kLeaf = 3;
/// Far above the rounding of boxes and of rays, so that a face is never lost whose border the ray grazes: its
/// neighbours would count their common edge without it.
constexpr double kMargin = 1e-6;

/// Cell on a side of a face: whether it exists and is not missing.
bool has_cell(const Block& block, const Face& face, bool before) {
  Dims cell{face.at[0], face.at[1], face.at[2]};
  if (before) --cell[face.axis];
  return cell[face.axis] >= 0 && cell[face.axis] < block.dims[face.axis] - 1 && !block.is_missing(cell);
}

Box3 hull(const FacePatch& patch) {
  Box3 box{patch[0], patch[0]};
  for (const Vec3& p : patch) {
    box.min = box.min.cwiseMin(p);
    box.max = box.max.cwiseMax(p);
  }
  return box;
}

void extend(Box3& box, const Box3& other) {
  box.min = box.min.cwiseMin(other.min);
  box.max = box.max.cwiseMax(other.max);
}

}  // namespace

struct FaceTree::Item {
  Face face;
  float min[3], max[3];
};

FaceTree::FaceTree(const Grid& grid, CellKind kind, double beta) {
  if (grid.blocks.size() >= 1u << 30) throw Error("rays: too many blocks");
  const auto each_face = [&](const auto& sink) {
    for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
      const Block& block = grid.blocks[b];
      for (std::uint32_t axis = 0; axis < 3; ++axis) {
        Dims n = block.cells();
        ++n[axis];
        for (std::int64_t k = 0; k < n[2]; ++k) {
          for (std::int64_t j = 0; j < n[1]; ++j) {
            for (std::int64_t i = 0; i < n[0]; ++i) {
              Face face;
              face.at = {static_cast<std::int32_t>(i), static_cast<std::int32_t>(j),
                         static_cast<std::int32_t>(k)};
              face.axis = axis & 3u;
              face.block = static_cast<std::uint32_t>(b) & 0x3fffffffu;
              if (has_cell(block, face, true) || has_cell(block, face, false)) {
                sink(face, hull(face_patch(block, face, kind, beta)));
              }
            }
          }
        }
      }
    }
  };
  std::size_t count = 0;
  each_face([&](const Face&, const Box3& box) {
    if (count++ == 0) bounds_ = box;
    extend(bounds_, box);
  });
  if (count == 0) throw Error("every cell of the grid is missing: nothing to see");
  if (count > std::numeric_limits<std::uint32_t>::max() / 2) throw Error("rays: too many faces");
  centre_ = bounds_.centre();
  scale_ = 0.5 * bounds_.size().maxCoeff();
  if (!(scale_ > 0) || !std::isfinite(scale_)) throw Error("the grid has no extent");
  std::vector<Item> items;
  items.reserve(count);
  each_face([&](const Face& face, const Box3& box) {
    Item item{face, {}, {}};
    for (int a = 0; a < 3; ++a) {
      item.min[a] = static_cast<float>((box.min[a] - centre_[a]) / scale_ - kMargin);
      item.max[a] = static_cast<float>((box.max[a] - centre_[a]) / scale_ + kMargin);
    }
    items.push_back(item);
  });
  faces_.reserve(count);
  nodes_.reserve(count);
  build(items, 0, count);
  nodes_.shrink_to_fit();
}

std::uint32_t FaceTree::build(std::vector<Item>& items, std::size_t begin, std::size_t end) {
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  float least[3], most[3];  // of twice the centres
  for (int a = 0; a < 3; ++a) {
    node.min[a] = least[a] = std::numeric_limits<float>::infinity();
    node.max[a] = most[a] = -std::numeric_limits<float>::infinity();
    for (std::size_t n = begin; n < end; ++n) {
      node.min[a] = std::min(node.min[a], items[n].min[a]);
      node.max[a] = std::max(node.max[a], items[n].max[a]);
      least[a] = std::min(least[a], items[n].min[a] + items[n].max[a]);
      most[a] = std::max(most[a], items[n].min[a] + items[n].max[a]);
    }
  }
  nodes_.push_back(node);
  if (end - begin <= kLeaf) {
    nodes_[at].first = static_cast<std::uint32_t>(faces_.size());
    nodes_[at].count = static_cast<std::uint32_t>(end - begin);
    for (std::size_t n = begin; n < end; ++n) faces_.push_back(items[n].face);
    return at;
  }
  int axis = 0;
  for (int a = 1; a < 3; ++a) {
    if (most[a] - least[a] > most[axis] - least[axis]) axis = a;
  }
  const std::size_t middle = begin + (end - begin) / 2;
  const auto first = items.begin();
  std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                   first + static_cast<std::ptrdiff_t>(end), [axis](const Item& a, const Item& b) {
                     return a.min[axis] + a.max[axis] < b.min[axis] + b.max[axis];
                   });
  build(items, begin, middle);
  const std::uint32_t second = build(items, middle, end);
  nodes_[at].first = second;
  return at;
}

void FaceTree::visit(const camera::Ray& ray, const std::function<void(const Face&)>& sink) const {
  double origin[3], inverse[3];
  for (int a = 0; a < 3; ++a) {
    origin[a] = (ray.origin[a] - centre_[a]) / scale_;
    const double d = ray.direction[a];
    inverse[a] = 1 / (std::abs(d) > 1e-30 ? d : 1e-30);
  }
  const auto misses = [&](const Node& node) {
    double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
    for (int a = 0; a < 3; ++a) {
      const double t0 = (static_cast<double>(node.min[a]) - origin[a]) * inverse[a];
      const double t1 = (static_cast<double>(node.max[a]) - origin[a]) * inverse[a];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    return !(enter <= leave);
  };
  std::uint32_t stack[64];  // halved each time: 2^32 faces are 32 deep
  int height = 0;
  stack[height++] = 0;
  while (height > 0) {
    const std::uint32_t at = stack[--height];
    const Node& node = nodes_[at];
    if (misses(node)) continue;
    for (std::uint32_t n = 0; n < node.count; ++n) sink(faces_[node.first + n]);
    if (node.count == 0) {
      stack[height++] = node.first;
      stack[height++] = at + 1;
    }
  }
}

}  // namespace vol::curvilinear
