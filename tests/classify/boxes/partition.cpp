#include "tests/classify/boxes/partition.h"

#include <gtest/gtest.h>

#include <limits>

#include "src/volume/block_layout.h"

namespace sluice {
namespace {

template <class Boxes>
VolumePartition partition(const DeviceVolume& volume, int64_t block_vox, Boxes&& boxes_of) {
  const BlockLayout layout = blockLayout(volume.dims, block_vox, 0);
  const GrowingParameters parameters = growingParameters(volume.map.type, volume.range);
  VolumePartition boxes;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    const Box3 owned = layout.ownedCells(layout.indexOf(block));
    for (const GrownBox& box : boxes_of(brickGrid(volume.span(), owned, kSide), parameters))
      boxes.push_back({translate(box.local(), owned.lo), box});
  }
  return boxes;
}

}  // namespace

VolumePartition grownPartition(const DeviceVolume& volume, int64_t block_vox) {
  return partition(volume, block_vox, growBoxes);
}

VolumePartition treePartition(const DeviceVolume& volume, int64_t block_vox) {
  return partition(volume, block_vox,
                   [](const BrickGrid& grid, const GrowingParameters& parameters) {
                     return growBoxTree(grid, parameters).boxes;
                   });
}

void expectRight(const DeviceVolume& volume, const VolumePartition& boxes) {
  const Vec3i size = volume.cells().size();
  std::vector<uint8_t> taken(static_cast<size_t>(sluice::volume(size)));
  int64_t cells = 0;
  for (const auto& [box, grown] : boxes) {
    ASSERT_FALSE(box.empty());
    ASSERT_TRUE(volume.cells().contains(box));
    float lo = std::numeric_limits<float>::max(), hi = std::numeric_limits<float>::lowest();
    for (int64_t z = box.lo.z; z <= box.hi.z; ++z)
      for (int64_t y = box.lo.y; y <= box.hi.y; ++y) {
        const float* row =
            &volume.values[static_cast<size_t>((z * volume.dims.y + y) * volume.dims.x)];
        for (int64_t x = box.lo.x; x <= box.hi.x; ++x) {
          lo = std::min(lo, row[x]);
          hi = std::max(hi, row[x]);
        }
        if (z == box.hi.z || y == box.hi.y) continue;
        uint8_t* cell = &taken[static_cast<size_t>((z * size.y + y) * size.x)];
        for (int64_t x = box.lo.x; x < box.hi.x; ++x) ASSERT_EQ(cell[x]++, 0);
      }
    ASSERT_EQ(grown.range.lo, lo);
    ASSERT_EQ(grown.range.hi, hi);
    cells += box.count();
  }
  EXPECT_EQ(cells, volume.cells().count());
}

}  // namespace sluice
