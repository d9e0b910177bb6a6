// A picture that is drawn strip by strip, so that only a strip of it is in memory. Strips share the
// plan and the contents of the levels. A strip reads and draws the blocks that it shows.
#pragma once

#include <functional>
#include <vector>

#include "src/device/device.h"
#include "src/device/picture_rows.h"
#include "src/render/frame/frame_report.h"

namespace sluice {

struct DrawnStrips {
  FrameReport report;  // the sum of all strips
  VisibleBlocksPtr blocks;
  bool shows_something = false;
};
// Draws each strip by a call of `draw`, the next frame of a session on `device`, and gives its
// picture to `take`, from the top down. The device draws whole pictures again afterwards. Requires:
// the device implements DrawsRows. Throws the errors of both functions.
DrawnStrips drawStrips(Device& device, const std::vector<PictureRows>& strips,
                       const std::function<Frame()>& draw,
                       const std::function<void(const Picture&)>& take);

}  // namespace sluice
