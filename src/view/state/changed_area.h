// ChangedArea: which parts of a window have to be drawn anew, from the triangles of its last frame
// and of this one. A window without a GPU shares its processors with what draws the volume: what is
// on the screen already costs it nothing. Plain data, pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sluice {

// Half-open, y downwards, screen units.
struct ScreenArea {
  float left = 0, top = 0, right = 0, bottom = 0;
  bool isEmpty() const { return right <= left || bottom <= top; }
  friend bool operator==(const ScreenArea&, const ScreenArea&) = default;
};
ScreenArea common(const ScreenArea& a, const ScreenArea& b);
// The least that holds both; an empty one holds nothing.
ScreenArea hull(const ScreenArea& a, const ScreenArea& b);

// As Dear ImGui has them.
struct DrawnVertex {
  float x = 0, y = 0, u = 0, v = 0;
  uint32_t color = 0;
  friend bool operator==(const DrawnVertex&, const DrawnVertex&) = default;
};
struct DrawnCommand {
  ScreenArea clip;
  uint64_t texture = 0;
  size_t first_index = 0, indices = 0;  // three a triangle
  size_t first_vertex = 0;              // to which the indices are added
};
// One of ImGui's windows.
struct DrawnList {
  std::string name;
  std::vector<DrawnVertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<DrawnCommand> commands;  // in the order that they are drawn in
};

// Holds every pixel that differs between two frames of one list, `redrawn` being the textures whose
// content is another now. The triangles that both frames begin with, and those that both end with,
// are the same pixels; the area is that of all between.
ScreenArea changedArea(const DrawnList& last, const DrawnList& now,
                       std::span<const uint64_t> redrawn = {});
// Of whole frames: areas that do not meet. Where other lists are there, or in another order, it is
// `all`.
std::vector<ScreenArea> changedAreas(std::span<const DrawnList> last,
                                     std::span<const DrawnList> now,
                                     std::span<const uint64_t> redrawn, const ScreenArea& all);
// None of them met by another: those that meet become their hull.
std::vector<ScreenArea> apart(std::vector<ScreenArea> areas);

}  // namespace sluice
