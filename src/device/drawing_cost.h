// How much work a box is, for devices that look up between pieces of a bounded size whether the
// picture is still wanted. Pure function.
#pragma once

#include "src/device/frame_values.h"

namespace sluice {

// About how many samples the rays of the view take in the box: of a perspective view from the
// distance of its centre, and as many as the picture can have where that is behind the eye.
double aboutSamples(const FrameSetup& setup, const Box3& cells);

}  // namespace sluice
