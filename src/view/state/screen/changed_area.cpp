#include "src/view/state/screen/changed_area.h"

#include <algorithm>

namespace sluice {
namespace {

struct Triangle {
  const DrawnCommand* command;
  std::array<const DrawnVertex*, 3> corners;
};

std::vector<Triangle> trianglesOf(const DrawnList& list) {
  std::vector<Triangle> triangles;
  triangles.reserve(list.indices.size() / 3);
  for (const DrawnCommand& command : list.commands)
    for (size_t i = 0; i + 2 < command.indices; i += 3) {
      Triangle triangle{&command, {}};
      for (size_t corner = 0; corner < 3; ++corner)
        triangle.corners[corner] =
            &list.vertices[command.first_vertex + list.indices[command.first_index + i + corner]];
      triangles.push_back(triangle);
    }
  return triangles;
}

bool areSame(const Triangle& a, const Triangle& b, std::span<const uint64_t> redrawn) {
  if (a.command->texture != b.command->texture || a.command->clip != b.command->clip) return false;
  // The triangle is the same and its texture's contents are not.
  if (std::ranges::find(redrawn, b.command->texture) != redrawn.end()) return false;
  for (size_t corner = 0; corner < 3; ++corner)
    if (*a.corners[corner] != *b.corners[corner]) return false;
  return true;
}

ScreenArea areaOf(std::span<const Triangle> triangles) {
  ScreenArea area;
  for (const Triangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.corners;
    const ScreenArea box{std::min({a->x, b->x, c->x}), std::min({a->y, b->y, c->y}),
                         std::max({a->x, b->x, c->x}), std::max({a->y, b->y, c->y})};
    // A triangle changes no pixel outside of its clip rectangle.
    area = hull(area, common(box, triangle.command->clip));
  }
  return area;
}

}  // namespace

ScreenArea common(const ScreenArea& a, const ScreenArea& b) {
  return {std::max(a.left, b.left), std::max(a.top, b.top), std::min(a.right, b.right),
          std::min(a.bottom, b.bottom)};
}

ScreenArea hull(const ScreenArea& a, const ScreenArea& b) {
  if (a.isEmpty()) return b.isEmpty() ? ScreenArea{} : b;
  if (b.isEmpty()) return a;
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
          std::max(a.bottom, b.bottom)};
}

ScreenArea changedArea(const DrawnList& last, const DrawnList& now,
                       std::span<const uint64_t> redrawn) {
  const std::vector<Triangle> before = trianglesOf(last), after = trianglesOf(now);
  // Lists mostly change in one place, so the common beginning and end are cut off; all between
  // counts as changed.
  const size_t shorter = std::min(before.size(), after.size());
  size_t first = 0;
  while (first < shorter && areSame(before[first], after[first], redrawn)) ++first;
  size_t ending = 0;
  while (first + ending < shorter &&
         areSame(before[before.size() - 1 - ending], after[after.size() - 1 - ending], redrawn))
    ++ending;
  const auto between = [&](const std::vector<Triangle>& all) {
    return areaOf(std::span(all).subspan(first, all.size() - first - ending));
  };
  // The old triangles have to be cleared and the new ones drawn.
  return hull(between(before), between(after));
}

std::vector<ScreenArea> changedAreas(std::span<const DrawnList> last,
                                     std::span<const DrawnList> now,
                                     std::span<const uint64_t> redrawn, const ScreenArea& all) {
  const auto same_name = [](const DrawnList& a, const DrawnList& b) { return a.name == b.name; };
  // Another list or another order: windows may cover each other in a new way.
  if (!std::ranges::equal(last, now, same_name)) return {all};
  std::vector<ScreenArea> areas;
  for (size_t i = 0; i < now.size(); ++i) {
    const ScreenArea area = common(changedArea(last[i], now[i], redrawn), all);
    if (!area.isEmpty()) areas.push_back(area);
  }
  return apart(std::move(areas));
}

std::vector<ScreenArea> apart(std::vector<ScreenArea> areas) {
  std::vector<ScreenArea> result;
  while (!areas.empty()) {
    ScreenArea area = areas.back();
    areas.pop_back();
    const auto met = std::ranges::find_if(
        result, [&](const ScreenArea& other) { return !common(area, other).isEmpty(); });
    if (met == result.end()) {
      result.push_back(area);
      continue;
    }
    // The hull may meet others that neither met.
    areas.push_back(hull(area, *met));
    result.erase(met);
  }
  return result;
}

}  // namespace sluice
