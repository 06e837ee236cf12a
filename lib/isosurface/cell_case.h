#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "isosurface/saddles.h"

namespace vol::isosurface {

// Corner x + 2 y + 4 z. Edge 4 a + u + 2 v is parallel to axis a, at u on axis a + 1 and v on axis a + 2
// (cyclic). Face 2 a + s is normal to axis a, at s.

[[nodiscard]] constexpr std::array<int, 2> edge_corners(int edge) {
  const int a = edge / 4;
  const int lower = (edge & 1) << ((a + 1) % 3) | ((edge >> 1) & 1) << ((a + 2) % 3);
  return {lower, lower | 1 << a};
}
/// The edge between two neighbouring corners.
[[nodiscard]] int edge_between(int corner, int other);
/// Corners of a face, counterclockwise as seen from outside the cell.
[[nodiscard]] constexpr std::array<int, 4> face_corners(int face) {
  const int a = face / 2;
  const int u = 1 << ((a + 1) % 3);
  const int v = 1 << ((a + 2) % 3);
  const int base = (face & 1) << a;
  if ((face & 1) != 0) return {base, base | u, base | u | v, base | v};
  return {base, base | v, base | u | v, base | u};
}

/// The isosurface of one cell as its corners and ambiguous faces decide it: closed loops of segments on the
/// faces, each the rim of a disk unless a tube joins two.
///
/// A loop has the inside on its right as seen from outside the cell, so that triangles in its sense have
/// normals from inside to outside. Disks are triangulated without a chord between two points of one face,
/// which the neighbour across might use as well: four triangles would meet there. Where that cannot be, the
/// disk is a fan about a point within the cell. Triangle corners: 0 to 11 the point on that edge, 12 + c the
/// fan's centre c.
struct CellCase {
  struct Loop {
    std::uint8_t first = 0, size = 0;                     ///< in `edges`
    std::uint8_t inside = 0, outside = 0;                 ///< the regions it separates
    std::uint8_t first_triangle = 0, triangle_count = 0;  ///< of its disk
    std::int8_t centre = -1;                              ///< of its fan; -1: none
  };
  std::uint8_t loop_count = 0, triangle_count = 0, centre_count = 0;
  std::array<Loop, 4> loops{};
  std::array<std::uint8_t, 12> edges{};
  std::array<std::uint8_t, 8> region{};  ///< of each corner: connected by edges and faces
  std::array<std::array<std::uint8_t, 3>, 12> triangles{};
};

/// All cases, derived from the faces when first asked for: bit c of `corners` is set where corner c is
/// inside, bit f of `joined` where face f is ambiguous and its inside corners are joined.
class CellCases {
 public:
  [[nodiscard]] static const CellCases& all();

  /// Faces with inside and outside corners alternating, bit f each.
  [[nodiscard]] std::uint8_t ambiguous_faces(int corners) const { return ambiguous_[corners]; }
  /// Edges with one end inside, bit e each.
  [[nodiscard]] std::uint16_t cut_edges(int corners) const { return cut_[corners]; }
  /// No ambiguous face and at most one loop: nothing is left to decide.
  [[nodiscard]] bool is_decided(int corners) const { return decided_[corners]; }
  [[nodiscard]] int number(int corners, int joined) const { return number_[corners * 64 + joined]; }
  [[nodiscard]] const CellCase& operator[](int number) const {
    return cases_[static_cast<std::size_t>(number)];
  }
  [[nodiscard]] int count() const { return static_cast<int>(cases_.size()); }

 private:
  CellCases();
  std::array<std::uint8_t, 256> ambiguous_{};
  std::array<std::uint16_t, 256> cut_{};
  std::array<bool, 256> decided_{};
  std::vector<std::uint16_t> number_;
  std::vector<CellCase> cases_;
};

/// The two loops that a tube joins; the first is the one about the diagonal's corner `diagonal`. -1: the tube
/// joins what the faces have joined already.
struct TubeLoops {
  int first = -1, second = -1;
  [[nodiscard]] bool any() const { return first >= 0; }
};
[[nodiscard]] TubeLoops tube_loops(const CellCase& cell, int corners, const Tube& tube);

/// How a cell is cut: the case, and the tube where there is one.
struct CellDecision {
  int corners = 0;
  int number = 0;  ///< of the case
  Tube tube;       ///< kind none unless it joins two loops
};
/// Decides a cell exactly (saddles.h). With `beyond_border`, some values are -infinity: no saddle lies
/// within.
[[nodiscard]] CellDecision decide(const CellValues& cell, bool beyond_border = false);

}  // namespace vol::isosurface
