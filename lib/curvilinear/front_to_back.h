#pragma once
#include <cstdint>
#include <utility>
#include <vector>

namespace vol::curvilinear {

/// Of two things in a list, by their places in it, the one that light from the other passes on its way to the
/// eye: the first is to be drawn before the second.
using Before = std::pair<std::uint32_t, std::uint32_t>;

/// An order of things, and where it breaks the relation it was made from.
struct FrontToBack {
  std::vector<std::uint32_t> order;  ///< places
  struct Stretch {
    std::size_t begin, end;
  };
  /// Of the order: things that go round in circles (strongly connected components of two and more; Tarjan
  /// 1972). Nothing outside of one is both in front of and behind what is in it.
  std::vector<Stretch> circles;
};

/// Puts `count` things, numbered by preference, in an order that keeps the relation but within circles: there
/// the one of the lowest number of those left is taken where none is free.
[[nodiscard]] FrontToBack front_to_back(std::uint32_t count, const std::vector<Before>& before);

}  // namespace vol::curvilinear
