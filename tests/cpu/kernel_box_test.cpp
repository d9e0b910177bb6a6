#include "src/cpu/kernels/kernel_box.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

FrameSetup setupOf(Vec3i dims, Projection projection, double azimuth_deg) {
  VolumeLayout layout;
  layout.dims = dims;
  FrameOptions options;
  options.camera.projection = projection;
  options.camera.azimuth_deg = azimuth_deg;
  options.camera.elevation_deg = 25;
  options.size = {100, 80};
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {1, 1, 1}}}, {{0, 0.1}}, "all"};
  return frameSetup(resolve(options.camera, layout, options.size, 1), layout,
                    OpacityTable(transfer, map, {0, 255}), map, options);
}

// Its texels are not looked at.
ChunkTexels chunkOf(Vec3i dims) {
  ChunkTexels chunk;
  chunk.storage_vox = chunk.size_vox = dims;
  chunk.byte_count = static_cast<size_t>(volume(dims));
  chunk.bytes = std::make_shared<std::byte[]>(chunk.byte_count);
  return chunk;
}

// The numbers of a chunk's bricks are single precision too: beyond 2^24 nothing is leapt over.
TEST(KernelBox, leapsOnlyWhereBricksHaveExactNumbers) {
  const Vec3i dims{65, 65, 65};
  const ChunkTexels chunk = chunkOf(dims);
  BoxDraw box;
  box.cells = boxOf(dims - Vec3i{1, 1, 1});
  const FrameSetup setup = setupOf(dims, Projection::kOrtho, 20);
  LeapGrid leaps;
  leaps.distances.assign(8, 1);
  for (const auto& [bricks, are_exact] :
       {std::pair{Vec3i{256, 256, 256}, true}, {Vec3i{512, 256, 256}, false}}) {
    leaps.bricks = bricks;
    std::vector<KernelBox> boxes;
    appendBox(setup, box, &chunk, &leaps, boxes);
    ASSERT_EQ(boxes.size(), 1U);
    EXPECT_EQ(boxes[0].distances != nullptr, are_exact) << bricks.x;
  }
}

// Offsets of texels in a large chunk are not exact in single precision: it is drawn in parts, which
// share the box without rest and come front to back.
TEST(KernelBox, largeBoxesAreDrawnInPartsFrontToBack) {
  const Vec3i dims{300, 300, 300};
  const ChunkTexels chunk = chunkOf(dims);
  BoxDraw box;
  box.cells = boxOf(dims - Vec3i{1, 1, 1});
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const double azimuth : {20.0, 160.0}) {
      const FrameSetup setup = setupOf(dims, projection, azimuth);
      std::vector<KernelBox> parts;
      appendBox(setup, box, &chunk, nullptr, parts);
      ASSERT_GT(parts.size(), 1U);
      double cells = 0;
      for (const KernelBox& part : parts) {
        cells += static_cast<double>(part.size[0]) * part.size[1] * part.size[2];
        EXPECT_LT(part.stride[2] * (part.texel_hi[2] + 2), 1 << 24);
      }
      EXPECT_EQ(cells, static_cast<double>(box.cells.count()));
      const Vec3d eye =
          setup.projection == Projection::kOrtho
              ? toDouble(dims) * 0.5 - setup.rays.step0 * 1e4
              : setup.rays.origin0 - setup.rays.step0 * (setup.first_depth / setup.depth_step);
      for (size_t i = 0; i + 1 < parts.size(); ++i) {
        const auto depthOf = [&](const KernelBox& part) {
          return std::abs((part.lo[2] + part.hi[2]) / 2 + setup.rays.origin0.z - eye.z);
        };
        EXPECT_LT(depthOf(parts[i]), depthOf(parts[i + 1])) << i;
      }
    }
}

TEST(KernelBox, boxesThatNoPixelSeesAreLeftOut) {
  const FrameSetup setup = setupOf({8, 8, 8}, Projection::kPerspective, 0);
  std::vector<KernelBox> boxes;
  BoxDraw box;
  box.cells = {{500, 0, 0}, {507, 7, 7}};
  appendBox(setup, box, nullptr, nullptr, boxes);
  EXPECT_TRUE(boxes.empty());
  box.cells = boxOf({7, 7, 7});
  appendBox(setup, box, nullptr, nullptr, boxes);
  EXPECT_EQ(boxes.size(), 1U);
}

}  // namespace
}  // namespace sluice
