// Partitions of whole volumes, block by block, and whether they are right by plain loops over cells
// and voxels.
#pragma once

#include <vector>

#include "src/classify/boxes/box_tree.h"
#include "tests/classify/device_volume.h"

namespace sluice {

// Cells of a brick in these tests, as in the program.
inline constexpr int64_t kSide = 4;

struct VolumeBox {
  Box3 cells;  // in the volume
  GrownBox box;
};
using VolumePartition = std::vector<VolumeBox>;

// Blocks of block_vox voxels a side: the grown boxes, and the leaves of their trees.
VolumePartition grownPartition(const DeviceVolume& volume, int64_t block_vox);
VolumePartition treePartition(const DeviceVolume& volume, int64_t block_vox);

// Expects every cell in exactly one box, and each interval to be the range of the voxels that the
// box's cells touch.
void expectRight(const DeviceVolume& volume, const VolumePartition& boxes);

}  // namespace sluice
