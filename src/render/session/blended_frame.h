// A frame that shows several channels of a volume as one medium: each sample of a ray blends what
// all channels show there (FrameSetup::others).
//
// Each channel keeps its session, and with it its plan, levels of memory and counters. The blocks
// of all channels are of one cut through the levels of resolution, and the clusters of their plans
// are the same parts of the volume (Session::parts()). The frame visits the clusters: the channels'
// chunks of a cluster are made resident, and then the boxes of each block are drawn together, one a
// channel that shows something there.
#pragma once

#include <vector>

#include "src/device/device.h"
#include "src/render/frame/frame_report.h"
#include "src/render/session/session.h"

namespace sluice {

// The next frame of the sessions that the parts are of, whose device draws setups with `others`,
// with the camera, the size and the rays of the first one's options. `reports`: set to a report
// each. The first one's volume places the grid in the world. Throws as Session::frame() does.
Frame blendedFrame(const Session::Parts& parts, Device& device, std::vector<FrameReport>& reports);

}  // namespace sluice
