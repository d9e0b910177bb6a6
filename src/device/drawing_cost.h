// How much work a box is, for devices that look up between pieces of a bounded size whether the
// picture is still wanted. Pure functions.
#pragma once

#include "src/device/frame_values.h"

namespace sluice {

// The most slices in the box that a ray like the one through the middle of the picture can meet.
double slicesAcross(const FrameSetup& setup, const Box3& cells);

// About how many samples the rays of the view take in the box. In a perspective view the distance
// of its centre counts, and the most that the picture can have if that is behind the eye.
double aboutSamples(const FrameSetup& setup, const Box3& cells);

}  // namespace sluice
