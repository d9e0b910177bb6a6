// TimeStep: everything known of a step of a volume without its voxels, the first value of a frame's
// chain: its levels of resolution, each with a source and ranges. A plain value; two are the same
// step if sources, time and ranges are the same objects.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/volume/pyramid.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// A level above the finest one.
struct CoarserStep {
  VolumeSource* source = nullptr;  // outlives whoever has the step
  // The ranges are those of its own voxels. Null: they are not known, and any block may show
  // something. A level that shows what the finest one shows (showsAsFinest()) needs none.
  std::shared_ptr<const SliceRanges> ranges;
  VolumeSource* spreads = nullptr;  // CoarserLevel::spreads
  LevelValues values = LevelValues::kUnknown;

  LevelValues valuesShown() const {
    return spreads != nullptr && values != LevelValues::kModes ? LevelValues::kMeans : values;
  }
  friend bool operator==(const CoarserStep&, const CoarserStep&) = default;
};

struct TimeStep {
  VolumeSource* source = nullptr;  // the finest level's source; outlives whoever has the step
  int64_t time = 0;
  std::shared_ptr<const SliceRanges> ranges;  // ranges of this step, in the layout of its blocks

  // For a volume of several levels: how they nest, and the steps of the levels above the finest,
  // from fine to coarse. Null and empty: there is one level.
  std::shared_ptr<const PyramidLayout> pyramid = nullptr;
  std::vector<CoarserStep> coarser = {};

  friend bool operator==(const TimeStep&, const TimeStep&) = default;

  PyramidLayout layout() const {
    return pyramid != nullptr ? *pyramid : PyramidLayout(ranges->layout);
  }
};

}  // namespace sluice
