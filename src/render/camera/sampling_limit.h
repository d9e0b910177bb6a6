// samplingLimit: how fast a device samples when nothing stands in its way, the yardstick of
// `sluice bench`: every pixel of the picture goes through one resident texture, nothing is skipped,
// looked up and blended as in a composite frame.
#pragma once

#include "src/device/device.h"

namespace sluice {

struct SamplingRate {
  double samples_per_second = 0;
  // By the time of all threads, which other work on the machine changes little.
  double samples_per_processor_second = 0;
};

// From the medians of `frames` frames after two warm ones.
SamplingRate samplingLimit(Device& device, PictureSize size, int frames);

}  // namespace sluice
