#pragma once
#include <span>

#include "curvilinear/gaps.h"

// Private to lib/curvilinear: cells that hide one another in turn.
namespace vol::curvilinear {

/// A part of a cell (or of a group of cells), a box of the parameters of its solid.
struct CellPart {
  std::uint32_t cell;  ///< place in the list
  Vec3 low, high;      ///< of the solid's parameters
};

struct CircleCounts {
  std::int64_t circles = 0;     ///< found among the cells
  std::int64_t split = 0;       ///< cells in them that were split
  std::int64_t unresolved = 0;  ///< circles left among parts where splitting ended
};

/// Splits the cells of circles until their parts have an order: the remedy that Bethel 1993 (figure 5) leaves
/// open. All parts in a circle are halved along their longest axis by de Casteljau, what is in front of what
/// is asked again between the parts, where their faces meet and where rays pass from one to another, and so
/// on in the circles that are left. Where sight goes along the axis of a twist there are circles at every
/// scale, whose parts hide ever less of one another: where kMostSplits halvings, one along each axis as a
/// rule, leave more than half of the parts in their circle, where parts are below kLeastPartPixels, and where
/// there are kMostParts or more, they keep the order that front_to_back() gives.
class Circles {
 public:
  /// \param cells  in the order that places refer to; refers to all of these
  /// \param gaps   of these cells, sorted by front, then back
  Circles(const std::vector<VisibleCell>& cells, const std::vector<Dims>& block_cells, SolidOf solid_of,
          const Screen& screen, const std::vector<GapCrossing>& gaps)
      : cells_(cells),
        block_cells_(block_cells),
        solid_of_(std::move(solid_of)),
        screen_(screen),
        gaps_(gaps) {}

  /// Adds the parts of a circle's members (places), front to back; of kMostParts or more the members whole,
  /// as they come: not even what is in front of what is asked.
  void split(std::span<const std::uint32_t> members, std::vector<CellPart>& parts,
             CircleCounts& counts) const;

 private:
  struct Part;
  void order(std::vector<Part> parts, std::vector<const GapCrossing*> gaps, int splits,
             std::vector<CellPart>& out, CircleCounts& counts) const;
  [[nodiscard]] Part part_of(std::uint32_t cell, const Solid& solid, const Vec3& low, const Vec3& high) const;

  const std::vector<VisibleCell>& cells_;
  const std::vector<Dims>& block_cells_;
  SolidOf solid_of_;
  const Screen& screen_;
  const std::vector<GapCrossing>& gaps_;
};
inline constexpr double kLeastPartPixels = 2;
inline constexpr int kMostSplits = 3;
inline constexpr std::size_t kMostParts = 4096;

}  // namespace vol::curvilinear
