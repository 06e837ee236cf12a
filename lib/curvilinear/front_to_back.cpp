#include "curvilinear/front_to_back.h"

#include <algorithm>
#include <functional>
#include <queue>

namespace vol::curvilinear {
namespace {

using Numbers = std::vector<std::uint32_t>;
using LowestFirst = std::priority_queue<std::uint32_t, Numbers, std::greater<>>;

/// What lies behind each thing, and how many lie in front.
struct Behind {
  std::vector<std::size_t> first;
  Numbers all, waits_for;

  Behind(std::uint32_t count, const std::vector<Before>& before)
      : first(count + 1U, 0), all(before.size()), waits_for(count, 0) {
    for (const auto& [a, b] : before) {
      ++first[a + 1];
      ++waits_for[b];
    }
    for (std::size_t n = 0; n < count; ++n) first[n + 1] += first[n];
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (const auto& [a, b] : before) all[next[a]++] = b;
  }
};

/// The strongly connected components, by Tarjan's algorithm without recursion. \returns of each thing its
/// component
Numbers components(std::uint32_t count, const Behind& behind, std::uint32_t& found) {
  constexpr std::uint32_t kNone = 0xffffffff;
  Numbers index(count, kNone), low(count, 0), of(count, kNone), stack, path;
  std::vector<std::size_t> next(behind.first.begin(), behind.first.end() - 1);
  std::uint32_t visited = 0;
  found = 0;
  for (std::uint32_t root = 0; root < count; ++root) {
    if (index[root] != kNone) continue;
    path.push_back(root);
    while (!path.empty()) {
      const std::uint32_t n = path.back();
      if (index[n] == kNone) {
        index[n] = low[n] = visited++;
        stack.push_back(n);
      }
      bool deeper = false;
      for (; next[n] < behind.first[n + 1] && !deeper; ++next[n]) {
        const std::uint32_t m = behind.all[next[n]];
        if (index[m] == kNone) {
          path.push_back(m);
          deeper = true;
          break;  // looked at again afterwards, for its low
        }
        if (of[m] == kNone) low[n] = std::min(low[n], low[m]);
      }
      if (deeper) continue;
      path.pop_back();
      if (low[n] != index[n]) continue;
      for (bool last = false; !last;) {
        const std::uint32_t m = stack.back();
        stack.pop_back();
        of[m] = found;
        last = m == n;
      }
      ++found;
    }
  }
  return of;
}

/// The members of a circle, the lowest number of those left where none is free.
void cut(const Numbers& members, const Numbers& component, const Behind& behind, Numbers& waits_for,
         Numbers& order) {
  LowestFirst ready;
  for (const std::uint32_t n : members) waits_for[n] = 0;
  for (const std::uint32_t n : members) {
    for (std::size_t k = behind.first[n]; k < behind.first[n + 1]; ++k) {
      if (component[behind.all[k]] == component[n]) ++waits_for[behind.all[k]];
    }
  }
  constexpr std::uint32_t kDone = 0xffffffff;
  std::size_t lowest = 0;
  for (std::size_t left = members.size(); left > 0; --left) {
    while (lowest < members.size() && waits_for[members[lowest]] == kDone) ++lowest;
    const std::uint32_t n = ready.empty() ? members[lowest] : ready.top();
    if (!ready.empty()) ready.pop();
    waits_for[n] = kDone;
    order.push_back(n);
    for (std::size_t k = behind.first[n]; k < behind.first[n + 1]; ++k) {
      const std::uint32_t m = behind.all[k];
      if (component[m] == component[n] && waits_for[m] != kDone && --waits_for[m] == 0) ready.push(m);
    }
  }
}

}  // namespace

FrontToBack front_to_back(std::uint32_t count, const std::vector<Before>& before) {
  const Behind behind(count, before);
  FrontToBack found;
  Numbers& order = found.order;
  order.reserve(count);
  Numbers waits_for = behind.waits_for;
  LowestFirst ready;
  for (std::uint32_t n = 0; n < count; ++n) {
    if (waits_for[n] == 0) ready.push(n);
  }
  while (!ready.empty()) {
    const std::uint32_t n = ready.top();
    ready.pop();
    order.push_back(n);
    for (std::size_t k = behind.first[n]; k < behind.first[n + 1]; ++k) {
      if (--waits_for[behind.all[k]] == 0) ready.push(behind.all[k]);
    }
  }
  if (order.size() == count) return found;

  // There are circles: the same with whole components.
  order.clear();
  std::uint32_t parts = 0;
  const Numbers component = components(count, behind, parts);
  std::vector<Numbers> members(parts);
  for (std::uint32_t n = 0; n < count; ++n) members[component[n]].push_back(n);
  Numbers part_waits_for(parts, 0);
  for (const auto& [a, b] : before) part_waits_for[component[b]] += component[a] != component[b];
  std::priority_queue<Before, std::vector<Before>, std::greater<>> ready_parts;  // lowest member, component
  for (std::uint32_t c = 0; c < parts; ++c) {
    if (part_waits_for[c] == 0) ready_parts.emplace(members[c].front(), c);
  }
  while (!ready_parts.empty()) {
    const std::uint32_t c = ready_parts.top().second;
    ready_parts.pop();
    const std::size_t begin = order.size();
    cut(members[c], component, behind, waits_for, order);
    if (members[c].size() > 1) found.circles.push_back({begin, order.size()});
    for (const std::uint32_t n : members[c]) {
      for (std::size_t k = behind.first[n]; k < behind.first[n + 1]; ++k) {
        const std::uint32_t other = component[behind.all[k]];
        if (other != c && --part_waits_for[other] == 0) ready_parts.emplace(members[other].front(), other);
      }
    }
  }
  return found;
}

}  // namespace vol::curvilinear
