// The coarsest level of a volume, which levels that sluice adds are made of.
#pragma once

#include "src/base/sources/volume_levels.h"

namespace sluice {

// The source itself if it has one level. Valid as long as `source`.
inline CoarserLevel coarsestLevel(VolumeSource& source) {
  const std::span<const CoarserLevel> levels = coarserLevels(source);
  if (!levels.empty()) return levels.back();
  return {.source = &source, .placement = {}};
}

// The placement among the finest voxels of a level that is placed among those of `below`.
inline LevelPlacement placedAbove(const LevelPlacement& below, const LevelPlacement& level) {
  return {below.scale * level.scale, below.finestFromLevel(level.offset)};
}

}  // namespace sluice
