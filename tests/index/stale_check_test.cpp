#include "src/index/stale_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "src/index/box_store.h"
#include "src/index/indexed_ranges.h"
#include "src/index/series_pass.h"
#include "src/index/volume_boxes.h"
#include "tests/support/error_of.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A volume with its arrays, and a buffer that compares the voxels from `read` with them.
struct Checked {
  Checked(VolumeSource& indexed, VolumeSource& read, const BlockLayout& blocks)
      : layout(blocks), check("v.raw"), buffer(read, blocks, uint64_t{64} << 20) {
    WorkerPool pool(2);
    ProgressMeter quiet;
    ranges = std::make_shared<SliceRanges>(buildSliceRanges(indexed, 0, layout, {pool, quiet}));
    check.expect({}, ranges);
    buffer.checkBy(
        [this](const BlockName& name, const VolumeBlock& block) { check.check(name, block); });
  }
  // How many of all blocks, taken one by one, contradict the arrays.
  int contradictions() {
    int count = 0;
    for (int64_t block = 0; block < layout.blockCount(); ++block) {
      const BlockName key{.block = block};
      try {
        buffer.acquire(std::span(&key, 1));
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("v.raw: block " + std::to_string(block)));
        ++count;
      }
    }
    return count;
  }

  BlockLayout layout;
  StaleCheck check;
  std::shared_ptr<SliceRanges> ranges;
  VolumeBuffer buffer;
};

TEST(StaleCheck, aVolumeAgreesWithItsOwnArraysInAnyTypeAndLayout) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI8, VoxelType::kU16, VoxelType::kI16,
                               VoxelType::kF32, VoxelType::kF64})
    for (const int ghost : {0, 1})
      for (const bool sparse : {true, false}) {
        SCOPED_TRACE(fmt::format("{} ghost {} sparse {}", name(type), ghost, sparse));
        BlobOptions options;
        options.type = type;
        const auto source =
            sparse ? makeSparseBlobs(options) : makeWhiteNoise({30, 41, 17}, type, 3);
        Checked volume(*source, *source, blockLayout(source->layout().dims, 16, ghost));
        EXPECT_EQ(volume.contradictions(), 0);
      }
}

TEST(StaleCheck, valuesThatAreNoNumbersAgreeWithThemselves) {
  VolumeLayout layout;
  layout.dims = {20, 20, 20};
  layout.type = VoxelType::kF32;
  FunctionSource source(layout, [](int64_t, Vec3i p) {
    if (p == Vec3i{3, 4, 5}) return std::numeric_limits<double>::quiet_NaN();
    if (p == Vec3i{3, 14, 5}) return std::numeric_limits<double>::infinity();
    return p.x == 2 ? 1e38 : p.y * 0.25;
  });
  Checked volume(source, source, blockLayout(layout.dims, 16, 1));
  EXPECT_EQ(volume.contradictions(), 0);
}

TEST(StaleCheck, eachBlockAroundAChangedVoxelContradicts) {
  VolumeLayout layout;
  layout.dims = {31, 31, 31};
  const auto zeros = [](int64_t, Vec3i) { return 0.0; };
  FunctionSource before(layout, zeros);
  // Blocks of 16 share plane 15: eight own this voxel.
  FunctionSource after(layout, [](int64_t, Vec3i p) { return p == Vec3i{15, 15, 15} ? 9.0 : 0.0; });
  EXPECT_EQ(Checked(before, after, blockLayout(layout.dims, 16, 0)).contradictions(), 8);
  // A ghost layer is not the block's own: cells 0 to 12 lie between planes 0 and 13.
  FunctionSource inside(layout, [](int64_t, Vec3i p) { return p == Vec3i{14, 2, 2} ? 9.0 : 0.0; });
  EXPECT_EQ(Checked(before, inside, blockLayout(layout.dims, 16, 1)).contradictions(), 1);
}

TEST(StaleCheck, otherTimeStepsAndForgottenArraysPass) {
  VolumeLayout layout;
  layout.dims = {20, 20, 20};
  layout.time_steps = 2;
  FunctionSource before(layout, [](int64_t, Vec3i) { return 0.0; });
  FunctionSource after(layout, [](int64_t, Vec3i) { return 1.0; });
  Checked volume(before, after, blockLayout(layout.dims, 16, 0));
  const BlockName later{.time = 1}, now{};
  EXPECT_NO_THROW(volume.buffer.acquire(std::span(&later, 1)));
  EXPECT_THROW(volume.buffer.acquire(std::span(&now, 1)), Error);
  volume.ranges.reset();
  EXPECT_NO_THROW(volume.buffer.acquire(std::span(&now, 1)));
}

// The error removes every index of the volume, and the next opening makes them anew.
TEST(StaleCheck, theIndicesOfTheVolumeAreRemoved) {
  const TempFolder folder;
  VolumeLayout layout;
  layout.dims = {20, 20, 20};
  layout.name = "v";
  FunctionSource before(layout, [](int64_t, Vec3i) { return 3.0; });
  FunctionSource after(layout, [](int64_t, Vec3i p) { return p.x == 9 ? 7.0 : 3.0; });
  const IndexPlaces places = indexPlaces((folder / "v").string(), {.folder = folder / "cache"});
  const BlockLayout blocks = blockLayout(layout.dims, 16, 0);
  WorkerPool pool(2);
  ProgressMeter quiet;
  const auto indexed = [&](VolumeSource& source) {
    return indexedRanges(source, places, 0, blocks, {pool, quiet});
  };
  EXPECT_EQ(indexed(before).origin, IndexOrigin::kBuilt);
  writeIndex(places, {before.identity(), "boxes", 1}, {});
  // The identity of a FunctionSource is its name: the change goes unseen.
  const IndexedRanges stale = indexed(after);
  ASSERT_EQ(stale.origin, IndexOrigin::kRead);
  EXPECT_EQ(stale.ranges.index_file, stale.path);
  Checked volume(before, after, blocks);
  volume.ranges->index_file = stale.path;
  const BlockName key{};
  EXPECT_THAT(
      errorOf([&] { volume.buffer.acquire(std::span(&key, 1)); }),
      AllOf(HasSubstr("v.raw: block 0 of time step 0 has values from 3 to 7, 3 to 3 when it "
                      "was indexed"),
            HasSubstr("was removed: give the same command again")));
  EXPECT_TRUE(std::filesystem::is_empty(stale.path.parent_path()));
  EXPECT_EQ(indexed(after).origin, IndexOrigin::kBuilt);
}

// Passes over the voxels that do not go through the volume buffer: one voxel of a step, or of a
// volume, is not what the arrays say.
VolumeLayout twoSteps() {
  VolumeLayout layout;
  layout.dims = {40, 20, 20};
  layout.time_steps = 2;
  layout.name = "v";
  return layout;
}
TransferFunction solid() {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{20, 0}, {90, 1}};
  return transfer;
}
double rising(int64_t, Vec3i p) {
  return static_cast<double>(100 + p.x);
}
double changed(int64_t time, Vec3i p) {
  return time == 1 && p == Vec3i{33, 9, 9} ? 240 : rising(time, p);
}

TEST(StaleCheck, opacityFunctionsAreNotMadeOfAChangedStep) {
  FunctionSource before(twoSteps(), rising), after(twoSteps(), changed);
  const BlockLayout blocks = blockLayout(before.layout().dims, 16, 0);
  const ExtinctionTable table(OpacityTable(solid(), deviceMap(before.layout()), {0, 255}));
  WorkerPool pool(2);
  ProgressMeter quiet;
  std::vector<StepBlocks> steps;
  for (int64_t time = 0; time < 2; ++time)
    steps.emplace_back(buildSliceRanges(before, time, blocks, {pool, quiet}), table);
  EXPECT_NO_THROW(makeSeriesOpacity(before, blocks, steps, table, {}, {pool, quiet}));
  EXPECT_THAT(errorOf([&] {
                makeSeriesOpacity(after, blocks, steps, table, {}, {pool, quiet});
              }),
              HasSubstr("v: block 2 of time step 1 has values from 130 to 240, 130 to 139 when it "
                        "was opened"));
}

TEST(StaleCheck, growingBoxesAreNotMadeOfAChangedStep) {
  const TempFolder folder;
  FunctionSource before(twoSteps(), rising), after(twoSteps(), changed);
  const IndexPlaces places = indexPlaces((folder / "v").string(), {.folder = folder / "cache"});
  const BlockLayout blocks = blockLayout(before.layout().dims, 16, 0);
  WorkerPool pool(2);
  ProgressMeter quiet;
  IndexedRanges index = indexedRanges(before, places, 1, blocks, {pool, quiet});
  index.ranges.index_file = index.path;
  const std::string expected =
      "v: block 2 of time step 1 has values from 130 to 240, 130 to 139 when it was indexed";
  BoxStore store(after, places, 1, index.ranges, pool, 1 << 20, kMostGrowingBytes);
  EXPECT_THAT(errorOf([&] { store.tree(2); }), HasSubstr(expected));
  EXPECT_TRUE(std::filesystem::is_empty(index.path.parent_path())) << "no boxes are kept either";
  const OpacityTable table(solid(), index.ranges.map, {0, 255});
  EXPECT_THAT(errorOf([&] {
                partitionCost(after, 1, index.ranges, table, boxOf(blocks.dims), {pool, quiet});
              }),
              HasSubstr(expected));
  const PartitionCost cost =
      partitionCost(before, 1, index.ranges, table, boxOf(blocks.dims), {pool, quiet});
  EXPECT_EQ(cost.blocks, static_cast<int64_t>(index.ranges.blocks.size()));
}

}  // namespace
}  // namespace sluice
