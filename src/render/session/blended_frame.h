// A frame that shows several channels of a volume as one medium: each sample of a ray blends what
// all channels show there (FrameSetup::others).
//
// Each channel keeps its session, and with it its plan, levels of memory and counters. The frame
// visits the clusters of all plans together: the channels' chunks of a cluster are made resident,
// and then the boxes of each block are drawn together, one a channel that shows something there.
#pragma once

#include <span>
#include <vector>

#include "src/device/device.h"
#include "src/render/frame/frame_report.h"
#include "src/render/session/session.h"

namespace sluice {

// The next frame of the sessions, whose device draws setups with `others`, with the camera, the
// size and the rays of the first one's options. `parts`: set to a report each. The sessions'
// volumes have one grid, which the first one places in the world, and the sessions one block size
// and number of pages. Throws as Session::frame() does.
Frame blendedFrame(std::span<Session* const> sessions, Device& device,
                   std::vector<FrameReport>& parts);

}  // namespace sluice
