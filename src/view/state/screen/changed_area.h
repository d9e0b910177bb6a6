// ChangedArea: which parts of a window have to be drawn anew, from the triangles of its last frame
// and of this one. A window without a GPU shares its processors with the renderer of the volume:
// pixels that are on the screen already should cost nothing. Plain data, pure functions.
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

// The layout of Dear ImGui's vertices.
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
// A window of ImGui.
struct DrawnList {
  std::string name;
  std::vector<DrawnVertex> vertices;
  std::vector<uint32_t> indices;
  std::vector<DrawnCommand> commands;  // in the order that they are drawn in
};

// Holds every pixel that differs between two frames of one list, `redrawn` being the textures whose
// content is another now. The triangles at the beginning and at the end that both frames share are
// the same pixels; the area covers all triangles between.
ScreenArea changedArea(const DrawnList& last, const DrawnList& now,
                       std::span<const uint64_t> redrawn = {});
// The changed areas of whole frames; they do not meet. `all` if the lists or their order differ.
std::vector<ScreenArea> changedAreas(std::span<const DrawnList> last,
                                     std::span<const DrawnList> now,
                                     std::span<const uint64_t> redrawn, const ScreenArea& all);
// The areas so that none meets another: those that meet become their hull.
std::vector<ScreenArea> apart(std::vector<ScreenArea> areas);

}  // namespace sluice
