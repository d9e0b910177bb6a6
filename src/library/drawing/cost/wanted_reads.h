// Counts how often the strips of a picture and its clusters want the blocks of a plan: a strip
// loads each chunk that has a block among its rows. Pure functions of plans.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/values/voxel_type.h"
#include "src/device/frame_values.h"
#include "src/device/pictures/picture_rows.h"
#include "src/texture/texture_plan.h"

namespace sluice {

// The bytes of a block as it is read, with the planes that it shares and with its spreads.
uint64_t decodedBytes(const PyramidLayout& layout, VoxelType type, const BlockName& block);

// The strips of a picture of a view.
class StripTally {
 public:
  // `strips`: as stripsOf() returns them; none: the picture is drawn whole. `setup`: of the view.
  StripTally(FrameSetup setup, std::span<const PictureRows> strips);

  // The number of strips that load a chunk whose blocks have these cells.
  int64_t loads(std::span<const Box3> blocks) const;
  // The cells that may show.
  const Box3& shown() const { return setup_.shown; }

 private:
  const FrameSetup setup_;
  const int64_t strips_;
  int rows_ = 0;  // of each strip but the highest
};

struct WantedReads {
  int64_t blocks = 0;
  uint64_t voxel_bytes = 0;

  // A block of so many bytes that is read so many times.
  void add(int64_t times, uint64_t block_bytes) {
    blocks += times;
    voxel_bytes += static_cast<uint64_t>(times) * block_bytes;
  }
};
// A chunk that two clusters need is wanted by each.
WantedReads wantedReads(const TexturePlan& textures, VoxelType type, const StripTally& strips);
// The same of a plan that is not made, in which each block is a chunk of its own cluster.
WantedReads wantedReadsOfEachBlock(const PyramidLayout& layout, const VisibleBlocks& visible,
                                   const PlanOptions& options, VoxelType type,
                                   const StripTally& strips);

}  // namespace sluice
