#include "src/visibility/occlusion/opacity_map.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"

namespace sluice {

MapRect intersect(const MapRect& a, const MapRect& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

MapRect unite(const MapRect& a, const MapRect& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

OpacityMap::OpacityMap(int side) : side_(side) {
  SLUICE_CHECK_LE(1, side);
  // Levels halve, rounded up, down to a single node.
  for (int size = side;; size = (size + 1) / 2) {
    levels_.push_back(
        {size, std::vector<float>(static_cast<size_t>(size) * static_cast<size_t>(size))});
    if (size == 1) break;
  }
}

void OpacityMap::update(std::span<const float> opacity) {
  SLUICE_CHECK_EQ(opacity.size(), levels_.front().least.size());
  // NaN hides nothing.
  std::transform(opacity.begin(), opacity.end(), levels_.front().least.begin(),
                 [](float value) { return value >= 0 ? value : 0; });
  for (size_t i = 1; i < levels_.size(); ++i) {
    const Level& fine = levels_[i - 1];
    Level& coarse = levels_[i];
    for (int y = 0; y < coarse.side; ++y)
      for (int x = 0; x < coarse.side; ++x) {
        // At an odd edge the last column or row stands for the missing one.
        const int right = std::min(2 * x + 1, fine.side - 1);
        const int above = std::min(2 * y + 1, fine.side - 1);
        coarse.least[static_cast<size_t>(y) * static_cast<size_t>(coarse.side) +
                     static_cast<size_t>(x)] =
            std::min({fine.at(2 * x, 2 * y), fine.at(right, 2 * y), fine.at(2 * x, above),
                      fine.at(right, above)});
      }
  }
  valid_ = true;
}

// Below a node: skipped if it is opaque, or if everything it could add has been found already.
void OpacityMap::addVisible(size_t level, int x, int y, const Pixels& asked, float threshold,
                            Pixels& found) const {
  // The node's pixels, as far as they were asked for.
  const int shift = static_cast<int>(level);
  const Pixels node{std::max(x << shift, asked.x0), std::max(y << shift, asked.y0),
                    std::min(((x + 1) << shift) - 1, asked.x1),
                    std::min(((y + 1) << shift) - 1, asked.y1)};
  if (node.x0 > node.x1 || node.y0 > node.y1) return;
  const bool adds_nothing =
      node.x0 >= found.x0 && node.x1 <= found.x1 && node.y0 >= found.y0 && node.y1 <= found.y1;
  if (adds_nothing || levels_[level].at(x, y) >= threshold) return;
  if (level == 0) {
    found = {std::min(found.x0, x), std::min(found.y0, y), std::max(found.x1, x),
             std::max(found.y1, y)};
    return;
  }
  const int last = levels_[level - 1].side - 1;
  // The far corner comes before the children between, so that the middle adds nothing.
  for (const int child : {0, 3, 1, 2}) {
    const int cx = 2 * x + (child & 1), cy = 2 * y + (child >> 1);
    if (cx <= last && cy <= last) addVisible(level - 1, cx, cy, asked, threshold, found);
  }
}

MapRect OpacityMap::visiblePart(const MapRect& rect, float threshold) const {
  if (rect.empty()) return {};
  const auto all = static_cast<double>(side_);
  const MapRect inside = intersect(rect, {0, 0, all, all});
  // Everything outside the map is visible, and so is everything before the first update.
  if (!valid_ || inside.empty()) return rect;
  MapRect visible;
  // The parts of `rect` outside the map are strips, one on each side that it crosses.
  if (rect.x0 < 0) visible = unite(visible, {rect.x0, rect.y0, 0, rect.y1});
  if (rect.x1 > all) visible = unite(visible, {all, rect.y0, rect.x1, rect.y1});
  if (rect.y0 < 0) visible = unite(visible, {rect.x0, rect.y0, rect.x1, 0});
  if (rect.y1 > all) visible = unite(visible, {rect.x0, all, rect.x1, rect.y1});
  // Pixels that the rectangle touches: a pixel that is covered in part may show there.
  const Pixels asked{static_cast<int>(inside.x0), static_cast<int>(inside.y0),
                     static_cast<int>(std::ceil(inside.x1)) - 1,
                     static_cast<int>(std::ceil(inside.y1)) - 1};
  Pixels found{side_, side_, -1, -1};
  addVisible(levels_.size() - 1, 0, 0, asked, threshold, found);
  if (found.x0 > found.x1) return visible;
  const MapRect pixels{static_cast<double>(found.x0), static_cast<double>(found.y0),
                       static_cast<double>(found.x1) + 1, static_cast<double>(found.y1) + 1};
  return unite(visible, intersect(pixels, rect));
}

}  // namespace sluice
