// Growing boxes in the frame: the picture of object boxes, whatever the view, the look and the
// memory; and their costs and savings.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "src/index/volume_boxes.h"
#include "src/render/camera/index_space.h"
#include "tests/render/blob_scene.h"
#include "tests/render/real_volumes.h"
#include "tests/support/counting_source.h"
#include "tests/support/random_volume.h"

namespace sluice::partition_test {
namespace {

constexpr double kOfReference = 2, kOfBlocks = 1;
// Blocks that are large compared with the blobs, so that boxes can leave something out.
constexpr SceneOptions kLargeBlocks{.block_vox = 32, .partition = Partition::kBoxes};

class PartitionTest : public RenderTest {
 protected:
  // Returns the boxes drawn.
  int64_t expectSamePicture(RenderScene& scene, FrameOptions options) {
    EXPECT_TRUE(boxesDrawTheSame(scene, options));
    options.partition = Partition::kBoxes;
    return scene.frame(options).report.boxes_drawn;
  }
};

TEST_F(PartitionTest, anyOctantProjectionAndLightingGivesTheSamePicture) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32})
    for (const bool lit : {false, true}) {
      const auto source = spacedBlobs(type);
      const ValueRange range = valueRangeOf(*source);
      RenderScene scene(device(), *source, thresholdTransfer(0.3 * range.hi, range, 0.2, "viridis"),
                        {.block_vox = 32, .lit = lit, .partition = Partition::kBoxes});
      for (int octant = 0; octant < 8; ++octant)
        for (const Projection projection : kProjections) {
          SCOPED_TRACE(fmt::format("{}, lit {}, octant {}, projection {}", name(type), lit, octant,
                                   static_cast<int>(projection)));
          FrameOptions options = obliqueView(projection, {64, 60});
          options.camera.azimuth_deg = 90 * (octant % 4) + 33;
          options.camera.elevation_deg = octant < 4 ? 35 : -35;
          options.with_depth = octant == 0;
          EXPECT_GT(expectSamePicture(scene, options), 8) << "no more boxes than blocks";
          options.partition = Partition::kBoxes;
          if (octant != 5) continue;
          EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
        }
    }
}

TEST_F(PartitionTest, axisAlignedAndInsideViewsGiveTheSamePicture) {
  const auto source = spacedBlobs(VoxelType::kU8, 2);
  RenderScene scene(device(), *source, someTransfer(), kLargeBlocks);
  for (const double azimuth : {0.0, 90.0, 180.0, 270.0})
    for (const double elevation : {0.0, 90.0, -90.0}) {
      FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
      options.camera.azimuth_deg = azimuth;
      options.camera.elevation_deg = elevation;
      expectSamePicture(scene, options);
    }
  for (const Vec3d eye : {Vec3d{0.5, 0.5, 0.5}, {0.2, 0.7, 0.4}, {0.9, 0.1, 0.6}, {0, 0, 0}})
    expectSamePicture(scene, insideView(source->layout(), eye, {0.6, 0.3, 0.8}));
}

TEST_F(PartitionTest, cropsClipPlanesModesAndStepsGiveTheSamePicture) {
  const auto source = spacedBlobs(VoxelType::kU8, 3);
  const Vec3d center =
      worldFromIndex(source->layout(), toDouble(source->layout().dims - Vec3i{1, 1, 1}) * 0.5);
  RenderScene scene(device(), *source, someTransfer(), kLargeBlocks);
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kMinip, Mode::kAverage,
                          Mode::kAttenuatedMip, Mode::kDepthMip})
    for (const Projection projection : kProjections)
      for (const double step : {0.5, 1.0, 1.7})
        for (const int cut : {0, 1, 2, 3}) {
          SCOPED_TRACE(fmt::format("mode {}, projection {}, step {}, cut {}",
                                   static_cast<int>(mode), static_cast<int>(projection), step,
                                   cut));
          FrameOptions options = obliqueView(projection, {64, 60});
          options.mode = mode;
          options.step_vox = step;
          if ((cut & 1) != 0) options.crop = Box3{{7, 9, 11}, {44, 41, 39}};
          if ((cut & 2) != 0)
            options.clip_planes = {{{0.3, -0.5, 0.8}, dot(Vec3d{0.3, -0.5, 0.8}, center)}};
          expectSamePicture(scene, options);
          if (step != 1 || cut != 3) continue;
          options.partition = Partition::kBoxes;
          EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
        }
}

TEST_F(PartitionTest, eachAlgorithmAndNoiseGiveTheSamePicture) {
  const auto noise = makeWhiteNoise({40, 37, 33}, VoxelType::kU8, 5);
  const auto sparse = spacedBlobs(VoxelType::kU8, 4);
  for (VolumeSource* source :
       {static_cast<VolumeSource*>(noise.get()), static_cast<VolumeSource*>(sparse.get())})
    for (const Algorithm algorithm : kAlgorithms) {
      RenderScene scene(device(), *source, someTransfer(90),
                        {.block_vox = 16, .partition = Partition::kBoxes});
      FrameOptions options = obliqueView(Projection::kPerspective, {64, 60});
      options.algorithm = algorithm;
      EXPECT_GT(expectSamePicture(scene, options), 0);
    }
}

TEST_F(PartitionTest, aNewTransferFunctionReadsNoVoxelForTheBoxes) {
  const auto source = spacedBlobs();
  CountingSource counting(*source);
  RenderScene scene(device(), counting, someTransfer(), kLargeBlocks);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.partition = Partition::kBoxes;
  counting.reset();
  const FrameReport first = scene.frame(options).report;
  EXPECT_EQ(static_cast<uint64_t>(counting.counts().bytes), first.decoded_bytes)
      << "what boxes are grown from is read through level 2 and counted there";
  EXPECT_GT(first.decoded_bytes, first.rebuild.decoded);
  EXPECT_EQ(scene.session().volumeBufferCounters().decoded_bytes, first.decoded_bytes);
  for (const double threshold : {90.0, 20.0, 150.0}) {
    counting.reset();
    scene.setTransfer(someTransfer(threshold));
    const FrameReport report = scene.frame(options).report;
    EXPECT_EQ(static_cast<uint64_t>(counting.counts().bytes), report.decoded_bytes)
        << "more than the blocks that were read";
    expectSamePicture(scene, options);
  }
}

TEST_F(PartitionTest, aSmallBudgetGivesTheSamePicture) {
  const auto source = spacedBlobs();
  const PageGeometry page{{8, 8, 8}, 1, 64};
  const RenderScene roomy(device(), *source, someTransfer(), {.block_vox = 16});
  const uint64_t least = textureMemoryBytes(page, TexelPlace::kInMemory) +
                         leastBufferBytes(page, needsOf(roomy.step(), Partition::kBoxes, 0));
  for (const uint64_t more : {0, 1000, 50'000, 1'000'000}) {
    RenderScene scene(device(), *source, someTransfer(),
                      {.block_vox = 16,
                       .pages = page.pages,
                       .memory_bytes = least + more,
                       .partition = Partition::kBoxes});
    EXPECT_GT(expectSamePicture(scene, obliqueView(Projection::kPerspective, {64, 60})), 0);
  }
}

TEST_F(PartitionTest, reportCountsBoxesAndFewerSamples) {
  const auto source = spacedBlobs();
  RenderScene scene(device(), *source, someTransfer(), kLargeBlocks);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  options.count_samples = true;
  options.algorithm = Algorithm::kTrimmed;
  const FrameReport blocks = scene.frame(options).report;
  EXPECT_EQ(blocks.boxes_drawn, blocks.blocks.grey + blocks.blocks.black);
  EXPECT_EQ(blocks.samples_drawn, blocks.samples_object);
  options.partition = Partition::kBoxes;
  const FrameReport boxes = scene.frame(options).report;
  EXPECT_GT(boxes.boxes_drawn, blocks.boxes_drawn);
  EXPECT_EQ(boxes.samples_object, blocks.samples_object);
  EXPECT_LT(boxes.samples_drawn, blocks.samples_drawn);
  EXPECT_GT(boxes.samples_drawn, blocks.samples_drawn / 10);
}

// A frame that does not wait draws object boxes if the growing ones are not made.
TEST_F(PartitionTest, aTimeLimitMakesNoBoxes) {
  const auto source = spacedBlobs();
  RenderScene scene(device(), *source, someTransfer(), kLargeBlocks);
  FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
  const FloatPicture expected = scene.draw(options);
  options.partition = Partition::kBoxes;
  options.time_limit_s = 100;
  const Frame limited = scene.frame(options);
  EXPECT_EQ(limited.report.boxes_drawn, limited.report.blocks.grey + limited.report.blocks.black);
  options.time_limit_s.reset();
  EXPECT_TRUE(within(kOfBlocks, scene.draw(options), expected));
}

class PartitionDataTest : public PartitionTest, public testing::WithParamInterface<RealVolume> {};

TEST_P(PartitionDataTest, boxesDrawTheSamePicture) {
  const auto file = openReal(GetParam());
  if (!file) GTEST_SKIP() << GetParam().input << " is not there";
  const auto source = middleOf(*file, {kSanitized ? 64 : 160, 160, 160}, GetParam().time);
  const Vec3i size = source->layout().dims;
  WorkerPool pool(2);
  ProgressMeter progress;
  const SliceRanges ranges =
      buildSliceRanges(*source, 0, blockLayout(size, 64, 0), {pool, progress});
  const TransferFunction transfer = automaticFor(ranges, file->layout());
  for (const bool lit : {false, true}) {
    RenderScene scene(device(), *source, transfer,
                      {.block_vox = 64, .lit = lit, .partition = Partition::kBoxes});
    for (const FrameOptions& view :
         {obliqueView(Projection::kOrtho, {96, 88}),
          obliqueView(Projection::kPerspective, {96, 88}),
          insideView(source->layout(), {0.45, 0.55, 0.6}, {0.2, 0.4, 0.3})})
      EXPECT_GT(expectSamePicture(scene, view), 0);
  }
  // The visible part of a growing box lies within its block's object box, which is made from other
  // numbers.
  const OpacityTable table(transfer, ranges.map, ranges.device_range);
  const Box3 all = boxOf(size - Vec3i{1, 1, 1});
  std::vector<Box3> object(static_cast<size_t>(ranges.layout.blockCount()));
  for (const ObjectBlock& block : classify(ranges, table, all, pool).blocks)
    object[static_cast<size_t>(block.name.block)] = block.cells;
  const auto held = std::count_if(ranges.blocks.begin(), ranges.blocks.end(), [&](int64_t block) {
    return !object[static_cast<size_t>(block)].empty();
  });
  std::atomic<int64_t> visible = 0, outside = 0;
  forEachBlockBricks(
      *source, 0, ranges.layout, ranges.blocks, {pool, progress},
      [&](int64_t block, const BrickGrid& grid) {
        const Box3& box = object[static_cast<size_t>(block)];
        for (const GrownBox& grown :
             growBoxTree(grid, growingParameters(ranges.map.type, ranges.device_range)).boxes) {
          if (!table.shown().anyIn(grown.range.lo, grown.range.hi)) continue;
          ++visible;
          if (intersect(translate(grown.local(), grid.cells.lo), box).empty()) ++outside;
        }
      });
  // Blocks of background alone may be all that shows.
  EXPECT_EQ(visible > 0, held > 0);
  EXPECT_EQ(outside, 0);
}

INSTANTIATE_TEST_SUITE_P(Data, PartitionDataTest, testing::ValuesIn(realVolumes()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace sluice::partition_test
