// Frames of one view whose pictures are added up, as those of the channels of a volume are.
#pragma once

#include <cstddef>
#include <vector>

#include "src/base/values/picture.h"

namespace sluice {

// A second interface of devices that draw several frames at once. The device's thread.
class AddsFrames {
 public:
  virtual ~AddsFrames() = default;
  // The device keeps the boxes of all frames until the end, beside the memory that is counted.
  static constexpr size_t kMostBoxesOfAFrame = 1 << 13;
  // The frames from now on are drawn at endSum(), and end with an empty picture each. Until then no
  // chunk that one of them draws may be evicted. Requires of the frames: composite ones of one grid
  // and one view, at most kMostBlended, of at most kMostBoxesOfAFrame boxes, without surfaces,
  // segments, depths, counts and an opacity map.
  virtual void beginSum() = 0;
  struct Sum {
    Picture picture;          // the pictures' sum, in the order of the frames, not limited
    std::vector<bool> shows;  // whether a pixel of each frame's picture has `least_opacity`
  };
  virtual Sum endSum(float least_opacity) = 0;
  // The frames are not wanted any more. May be called if no sum is under way.
  virtual void cancelSum() = 0;
};

}  // namespace sluice
