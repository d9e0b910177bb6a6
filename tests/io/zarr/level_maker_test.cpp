// The layers of levels that are held while cubes of voxels come.
#include "io/zarr/levels/level_maker.h"

#include <gtest/gtest.h>

#include <vector>

namespace sluice {
namespace {

// Places that no cube came for are fill in every layer, whatever their memory held before.
TEST(LevelMaker, fillsPlacesThatNoCubeCameFor) {
  VolumeLayout layout;
  layout.dims = {64, 32, 64};
  layout.type = VoxelType::kU8;
  constexpr int64_t kSide = 32;
  const std::vector<LevelShape> shapes = levelShapes(layout, kSide, 1);
  const std::byte fill{7};
  LevelMaker maker(layout, kSide, shapes, Downsample::kMean, {&fill, 1});
  const std::vector<std::byte> nine(size_t{kSide} * kSide * kSide, std::byte{9});
  maker.add({{32, 0, 32}, {64, 32, 64}}, nine.data(), kSide, kSide * kSide);
  maker.endLayer(0);
  const std::byte* const voxels = maker.layerVoxels(0);
  const std::byte* const spreads = maker.layerSpreads(0);
  const Vec3i dims = shapes.front().dims;
  for (int64_t z = 0; z < dims.z; ++z)
    for (int64_t x = 0; x < dims.x; ++x) {
      const auto at = static_cast<size_t>(z * dims.y * dims.x + x);
      EXPECT_EQ(voxels[at], std::byte{x < 16 || z < 16 ? uint8_t{7} : uint8_t{9}});
      EXPECT_EQ(spreads[at], std::byte{0});
    }
}

}  // namespace
}  // namespace sluice
