// samplingLimit: how fast a device samples when nothing stands in its way, the yardstick of
// `sluice bench`: every pixel of the picture goes through one resident texture, nothing is skipped,
// looked up and blended as in a composite frame.
#pragma once

#include "src/device/device.h"

namespace sluice {

// Samples a second, from the median of `frames` frames after two warm ones.
double samplingLimit(Device& device, PictureSize size, int frames);

}  // namespace sluice
