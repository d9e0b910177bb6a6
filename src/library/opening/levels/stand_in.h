// StandIn: what is known of the values of a finest level that has no min-max arrays, so that a
// picture of coarse levels does not wait for a pass over it.
//
// Range, counts and the place of what is visible are the same for blocks of any size. They come
// from an index of other blocks if one is kept. A pyramid that another program made, or a store
// without its index, has none. Then they come from the coarsest level that is large enough, which
// is read instead: they are close to those of the finest level, not equal, since means have a
// narrower range. Nothing is known of the finest level's blocks either way, so that anything may
// show in them (SliceRanges::unknown).
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "src/base/sources/volume_levels.h"
#include "src/classify/blocks/visible_cells.h"
#include "src/index/indexed_ranges.h"
#include "src/render/blocks/time_step.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// The values that a level's voxels are drawn with, see ExpectedLook.
struct ReachRanges {
  BrickRanges bricks;
  PlaneRanges planes;

  uint64_t bytes() const { return bricks.bytes() + planes.bytes(); }
};

struct StandIn {
  int level = 0;                               // counted from the finest, 0: by other blocks
  std::shared_ptr<const IndexedRanges> index;  // of the level's voxels, without their spreads
  ValueRange device_range;                     // of the finest level, estimated
  // The values with their spreads; null: the level has none.
  std::shared_ptr<const ReachRanges> reach = {};
};

// A level with fewer voxels is no stand-in, if there is a larger one.
inline constexpr int64_t kLeastStandInVoxels = int64_t{1} << 21;

// The coarsest level of the pyramid with at least kLeastStandInVoxels, or else the finest above
// level 0. Requires: several levels.
int standInLevel(const PyramidLayout& pyramid);

struct SpreadReach {
  // The values of which means and spreads may be: the means' own range, widened so far that each
  // mean can have its spread if the other end of the range is right. The finest values may reach
  // farther.
  ValueRange range;
  ReachRanges drawn;  // within `range`, perhaps more than what is drawn
};
// Reads both sources once. `means` is the range of the means, `cells` those that bricks cover.
SpreadReach reachOfSpreads(const CoarserLevel& level, ValueRange means, const Box3& cells,
                           int64_t time, WorkerPool& pool, const StopToken& stop = {});

// The bytes of them while they are made, of a level of these voxels.
uint64_t reachBytes(Vec3i dims, DeviceType type);

// Whether a picture from any of these cameras draws a part at the finest level. `step` may have
// unknown blocks. Requires: frame.cut is set, several levels.
bool showsFinest(const TimeStep& step, const TransferFunction& transfer, FrameOptions frame,
                 std::span<const Camera> cameras, WorkerPool& pool);

}  // namespace sluice
