#pragma once
#include <functional>
#include <vector>

#include "camera/camera.h"
#include "curvilinear/face.h"

namespace vol::curvilinear {

/// The faces of a grid's cells, each once, in a hierarchy of boxes. About 200 bytes a cell.
class FaceTree {
 public:
  /// Refers to the grid, which must live longer. A face between two missing cells, or between one and
  /// nothing, is left out.
  FaceTree(const Grid& grid, CellKind kind, double beta);

  /// Calls with every face whose control points' box the line of the ray meets, and with some more.
  void visit(const camera::Ray& ray, const std::function<void(const Face&)>& sink) const;
  /// Of the control points, which hold the solids.
  [[nodiscard]] const Box3& bounds() const { return bounds_; }
  [[nodiscard]] std::size_t face_count() const { return faces_.size(); }

 private:
  /// Box in coordinates that put the grid's hull into [-1, 1]^3, rounded outward; a leaf holds `count` faces
  /// from `first` on, another node the two nodes at itself + 1 and at `first`.
  struct Node {
    float min[3], max[3];
    std::uint32_t first = 0, count = 0;
  };
  struct Item;
  std::uint32_t build(std::vector<Item>& items, std::size_t begin, std::size_t end);

  std::vector<Face> faces_;
  std::vector<Node> nodes_;
  Box3 bounds_;
  Vec3 centre_;
  double scale_ = 1;
};

}  // namespace vol::curvilinear
