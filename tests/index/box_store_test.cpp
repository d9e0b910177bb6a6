// Trees from the store against trees made on the spot; which data is read, kept and forgotten.
#include "src/index/box_store.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "src/index/volume_boxes.h"
#include "tests/classify/boxes/partition.h"
#include "tests/support/counting_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/support/temp_folder.h"

namespace sluice::box_store_test {
namespace {

constexpr uint64_t kPlenty = uint64_t{1} << 30;

class BoxStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    BlobOptions options;
    // Blocks of 15 cells: 8 x 8 x 7 of them, in two pieces.
    options.dims = {120, 117, 100};
    options.blobs = 60;
    options.radius_vox = 20;
    blobs_ = makeSparseBlobs(options);
    source_.emplace(*blobs_);
    layout_ = blockLayout(options.dims, 16, 0);
    ranges_ = buildSliceRanges(*source_, 0, layout_, {pool_, progress_});
    ASSERT_GT(layout_.blockCount(), BoxStore::kPieceBlocks);
    source_->reset();
  }
  IndexPlaces places() const { return indexPlaces((folder_ / "blobs.raw").string(), wish_); }
  BoxStore store(uint64_t budget_bytes = kPlenty) {
    return {*source_, places(), 0, ranges_, pool_, budget_bytes, kMostGrowingBytes};
  }
  BoxTree expected(int64_t block) const {
    const DeviceVolume volume(*blobs_);
    const Box3 cells = layout_.ownedCells(layout_.indexOf(block));
    return growBoxTree(brickGrid(volume.span(), cells, kGrowingBrickSide),
                       growingParameters(ranges_.map.type, ranges_.device_range));
  }
  int64_t heldIn(int64_t first, int64_t end) const {
    return std::count_if(ranges_.blocks.begin(), ranges_.blocks.end(),
                         [&](int64_t block) { return block >= first && block < end; });
  }
  std::vector<std::filesystem::path> indexFiles() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path()))
      if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
  }

  TempFolder folder_;
  IndexWish wish_{.folder = folder_ / "cache"};
  WorkerPool pool_{2};
  ProgressMeter progress_;
  std::unique_ptr<MemorySource> blobs_;
  std::optional<CountingSource> source_;
  BlockLayout layout_;
  SliceRanges ranges_;
};

TEST_F(BoxStoreTest, treesAreThoseOfTheVoxelsAndComeFromTheIndexTheNextTime) {
  std::vector<int64_t> blocks;
  for (size_t i = 0; i < ranges_.blocks.size(); i += 29) blocks.push_back(ranges_.blocks[i]);
  ASSERT_GT(blocks.back(), BoxStore::kPieceBlocks);
  BoxStore made = store();
  for (const int64_t block : blocks) EXPECT_EQ(*made.tree(block), expected(block)) << block;
  EXPECT_EQ(made.counters().pieces_built, 2);
  EXPECT_EQ(made.counters().pieces_read, 0);
  EXPECT_GT(source_->counts().calls, 0);
  source_->reset();
  BoxStore found = store();
  for (const int64_t block : blocks) EXPECT_EQ(*found.tree(block), expected(block)) << block;
  EXPECT_EQ(found.counters().pieces_built, 0);
  EXPECT_EQ(found.counters().pieces_read, 2);
  EXPECT_EQ(source_->counts().calls, 0) << "not one voxel";
}

TEST_F(BoxStoreTest, whatIsNotMadeYetIsMadeOnlyWhereThatIsAskedFor) {
  const int64_t block = ranges_.blocks.front();
  BoxStore boxes = store();
  EXPECT_EQ(boxes.treeIfMade(block), nullptr);
  EXPECT_EQ(source_->counts().calls, 0);
  boxes.tree(block);
  EXPECT_NE(boxes.treeIfMade(ranges_.blocks[1]), nullptr) << "of the piece that was made";
  BoxStore later = store();
  source_->reset();
  ASSERT_NE(later.treeIfMade(block), nullptr) << "from the index";
  EXPECT_EQ(*later.treeIfMade(block), expected(block));
  EXPECT_EQ(source_->counts().calls, 0);
}

TEST_F(BoxStoreTest, onlyThePieceThatIsAskedForIsRead) {
  BoxStore boxes = store();
  boxes.tree(ranges_.blocks.back());
  const int64_t end = layout_.blockCount(), first = BoxStore::kPieceBlocks;
  int64_t most_voxels = heldIn(first, end) * 18 * 18 * 18;
  EXPECT_LE(source_->counts().voxels, most_voxels);
  EXPECT_EQ(boxes.counters().pieces_built, 1);
  EXPECT_EQ(indexFiles().size(), 1U);
}

TEST_F(BoxStoreTest, whatIsKeptStaysWithinTheBudgetAndTheLongestUnusedGoesFirst) {
  const int64_t a = ranges_.blocks[0], b = ranges_.blocks[1], c = ranges_.blocks[2];
  const uint64_t budget = expected(a).bytes() + expected(b).bytes() + expected(c).bytes() - 1;
  BoxStore boxes = store(budget);
  const BoxTreePtr held = boxes.tree(b);
  boxes.tree(a);
  boxes.tree(c);  // b goes
  EXPECT_LE(boxes.counters().peak_bytes, budget);
  EXPECT_EQ(boxes.counters().hits, 0);
  boxes.tree(a);
  boxes.tree(c);
  EXPECT_EQ(boxes.counters().hits, 2);
  EXPECT_EQ(*boxes.tree(b), *held) << "what was handed out lives on";
  EXPECT_EQ(boxes.counters().hits, 2);
  for (const int64_t block : ranges_.blocks) boxes.tree(block);
  EXPECT_LE(boxes.counters().peak_bytes, budget);
  EXPECT_GT(boxes.counters().current_bytes, 0U);
}

TEST_F(BoxStoreTest, aTreeBeyondTheBudgetIsGivenAndNotKept) {
  BoxStore boxes = store(1);
  EXPECT_EQ(*boxes.tree(ranges_.blocks[0]), expected(ranges_.blocks[0]));
  EXPECT_EQ(*boxes.tree(ranges_.blocks[0]), expected(ranges_.blocks[0]));
  EXPECT_EQ(boxes.counters().current_bytes, 0U);
  EXPECT_EQ(boxes.counters().pieces_built, 1);
}

TEST_F(BoxStoreTest, aDamagedIndexIsMadeAnew) {
  const int64_t block = ranges_.blocks[0];
  store().tree(block);
  ASSERT_EQ(indexFiles().size(), 1U);
  const std::filesystem::path path = indexFiles().front();
  std::string bytes = readFile(path);
  bytes[bytes.size() / 2] ^= 1;
  writeFile(path, bytes);
  BoxStore boxes = store();
  EXPECT_EQ(*boxes.tree(block), expected(block));
  EXPECT_EQ(boxes.counters().pieces_built, 1);
  BoxStore again = store();
  again.tree(block);
  EXPECT_EQ(again.counters().pieces_read, 1) << "and is whole again";
}

TEST_F(BoxStoreTest, whatAPassOverAllBlocksKeepsIsFoundByTheStore) {
  BoxIndexWriter index(*source_, places(), 0, ranges_);
  forEachBlockBricks(*source_, 0, layout_, ranges_.blocks, {pool_, progress_},
                     [&](int64_t block, const BrickGrid& grid) {
                       index.add(block, growBoxTree(grid, growingParameters(ranges_.map.type,
                                                                            ranges_.device_range)));
                     });
  EXPECT_EQ(index.piecesWritten(), 2);
  source_->reset();
  BoxStore boxes = store();
  for (const int64_t block : {ranges_.blocks.front(), ranges_.blocks.back()})
    EXPECT_EQ(*boxes.tree(block), expected(block));
  EXPECT_EQ(boxes.counters().pieces_read, 2);
  EXPECT_EQ(source_->counts().calls, 0);
}

TEST_F(BoxStoreTest, withoutAnIndexNothingIsWritten) {
  wish_.disabled = true;
  BoxStore boxes = store();
  EXPECT_EQ(*boxes.tree(ranges_.blocks[0]), expected(ranges_.blocks[0]));
  EXPECT_TRUE(indexFiles().empty());
}

TEST_F(BoxStoreTest, severalThreadsGetTheSameTrees) {
  BoxStore boxes = store(4096);
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  const BoxTree first = expected(ranges_.blocks.front()), last = expected(ranges_.blocks.back());
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      for (int round = 0; round < 5; ++round) {
        wrong += *boxes.tree(ranges_.blocks.front()) == first ? 0 : 1;
        wrong += *boxes.tree(ranges_.blocks.back()) == last ? 0 : 1;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(BoxStore, aBlockOfBackgroundIsOneBoxAndIsNotRead) {
  VolumeLayout layout;
  layout.dims = {64, 64, 64};
  FunctionSource sparse(
      layout, [](int64_t, Vec3i p) { return p.x < 8 ? 90.0 : 5.0; },
      Occupancy{5, {{{0, 0, 0}, {8, 64, 64}}}});
  WorkerPool pool(2);
  ProgressMeter progress;
  const SliceRanges ranges =
      buildSliceRanges(sparse, 0, blockLayout(layout.dims, 32, 0), {pool, progress});
  CountingSource source(sparse);
  BoxStore boxes(source, IndexPlaces(), 0, ranges, pool, kPlenty, kMostGrowingBytes);
  const BoxTreePtr tree = boxes.tree(2);
  EXPECT_EQ(source.counts().calls, 0);
  ASSERT_EQ(tree->boxes.size(), 1U);
  EXPECT_EQ(tree->boxes[0].local(), boxOf(ranges.layout.ownedCells({2, 0, 0}).size()));
  EXPECT_EQ(tree->boxes[0].range.lo, 5);
  EXPECT_EQ(tree->boxes[0].range.hi, 5);
  EXPECT_EQ(tree->textures, tree->boxes);
}

}  // namespace
}  // namespace sluice::box_store_test
