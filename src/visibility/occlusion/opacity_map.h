// OpacityMap: the orthogonal opacity map on the CPU's side (Li 2003, sections 4.1 and 4.3), asked
// which part of a rectangle is not opaque yet.
//
// The map lies in a plane orthogonal to the axis that the view is most parallel to; each of its
// pixels holds the least opacity of the part of the picture that it covers, so that a pixel at or
// above the threshold hides everything behind it. Over the pixels lies a pyramid of minima, each
// level half as large, so that an opaque region is recognised without looking at its pixels. Map
// coordinates are continuous: pixel (i, j) covers [i, i + 1) x [j, j + 1). Everything outside the
// map is visible. Immutable between updates; any thread may ask.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sluice {

// Half-open, in map coordinates. Empty if lo >= hi on an axis.
struct MapRect {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool empty() const { return !(x0 < x1 && y0 < y1); }
  friend bool operator==(const MapRect&, const MapRect&) = default;
};
// Empty if they do not overlap.
MapRect intersect(const MapRect& a, const MapRect& b);
// The smallest that holds both; an empty one adds nothing.
MapRect unite(const MapRect& a, const MapRect& b);

class OpacityMap {
 public:
  static constexpr int kDefaultSide = 64;

  // Nothing is opaque yet. Requires: side >= 1.
  explicit OpacityMap(int side = kDefaultSide);

  int side() const { return side_; }
  // False until the first update: everything is visible.
  bool valid() const { return valid_; }
  // Row after row, from y = 0. Requires: opacity.size() == side * side.
  void update(std::span<const float> opacity);

  // The opacity of the map's pixel.
  float at(int x, int y) const { return levels_.front().at(x, y); }

  // Whether all of `rect` lies on pixels at or above the threshold, so that anything projecting
  // there is hidden. An empty one is.
  bool isOpaque(const MapRect& rect, float threshold) const {
    return visiblePart(rect, threshold).empty();
  }
  // The bounds of the visible part of `rect`: of its pixels below the threshold and of its parts
  // outside the map, cut to the rectangle. Empty when nothing does.
  MapRect visiblePart(const MapRect& rect, float threshold) const;

 private:
  struct Level {
    int side = 1;
    std::vector<float> least;
    float at(int x, int y) const {
      return least[static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x)];
    }
  };
  // Inclusive bounds of pixels.
  struct Pixels {
    int x0, y0, x1, y1;
  };

  void addVisible(size_t level, int x, int y, const Pixels& asked, float threshold,
                  Pixels& found) const;

  int side_;
  bool valid_ = false;
  std::vector<Level> levels_;  // the pixels first, a single element last
};

}  // namespace sluice
