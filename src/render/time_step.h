// TimeStep: what is known of a step of a volume without its voxels, the first value of a frame's
// chain. A plain value; two are the same step where source, time and ranges are the same objects.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "src/base/volume_source.h"
#include "src/volume/slice_ranges.h"

namespace sluice {

struct TimeStep {
  VolumeSource* source = nullptr;  // outlives whoever has the step
  int64_t time = 0;
  std::shared_ptr<const SliceRanges> ranges;  // of this step, in the layout of its blocks

  friend bool operator==(const TimeStep&, const TimeStep&) = default;
};

}  // namespace sluice
