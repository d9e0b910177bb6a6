// Boxes that are drawn together, see BoxDraw::joins. Pure functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "src/device/frame_values.h"

namespace sluice {

// How many boxes at the front of a list are drawn together: the first and those that join it.
inline size_t countTogether(std::span<const BoxDraw> boxes) {
  size_t count = boxes.empty() ? 0 : 1;
  while (count < boxes.size() && boxes[count].joins) ++count;
  return count;
}

// The most boxes of a list that are drawn together.
inline size_t mostTogether(std::span<const BoxDraw> boxes) {
  size_t most = 0;
  for (; !boxes.empty(); boxes = boxes.subspan(countTogether(boxes)))
    most = std::max(most, countTogether(boxes));
  return most;
}

}  // namespace sluice
