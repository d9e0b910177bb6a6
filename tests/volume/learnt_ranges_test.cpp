#include "src/volume/ranges/learnt_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "src/volume/volume_buffer.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

struct Learning {
  explicit Learning(VolumeSource& volume)
      : source(volume),
        layout(blockLayout(volume.layout().dims, 16, 2)),
        learnt(0, std::make_shared<const SliceRanges>(unknownRanges(volume, 0, layout))) {}
  // Notes these blocks as pictures do that read them.
  void read(const std::vector<int64_t>& blocks) {
    VolumeBuffer buffer(source, layout, uint64_t{1} << 28);
    for (const int64_t block : blocks) {
      const BlockName name{.block = block};
      const auto found = buffer.acquire(std::span(&name, 1));
      learnt.note(name, *found.front());
    }
  }
  SliceRanges whole() const {
    WorkerPool pool(2);
    ProgressMeter progress;
    return buildSliceRanges(source, 0, layout, {pool, progress});
  }

  VolumeSource& source;
  const BlockLayout layout;
  LearntRanges learnt;
};

std::vector<int64_t> shuffled(int64_t count) {
  std::vector<int64_t> blocks(static_cast<size_t>(count));
  for (size_t i = 0; i < blocks.size(); ++i) blocks[i] = static_cast<int64_t>(i);
  std::mt19937 random(7);
  std::shuffle(blocks.begin(), blocks.end(), random);
  return blocks;
}

TEST(LearntRanges, ofAllBlocksAreThoseOfAPassOverTheVolume) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kU16, VoxelType::kF32}) {
    const auto source = makeSparseBlobs({.dims = {53, 47, 61}, .type = type, .blobs = 6});
    Learning learning(*source);
    const std::vector<int64_t> blocks = shuffled(learning.layout.blockCount());
    // In parts, so that ranges are joined to some that are known.
    const size_t half = blocks.size() / 2;
    learning.read({blocks.begin(), blocks.begin() + static_cast<ptrdiff_t>(half)});
    EXPECT_EQ(learning.learnt.ranges()->unknown.size(), blocks.size() - half);
    learning.read(blocks);
    const auto found = learning.learnt.ranges();
    const SliceRanges expected = learning.whole();
    ASSERT_EQ(expected.background, found->background);
    EXPECT_LT(expected.blocks.size(), blocks.size()) << "some blocks are all background";
    EXPECT_EQ(found->blocks, expected.blocks);
    EXPECT_EQ(found->totals, expected.totals);
    EXPECT_EQ(found->planes, expected.planes);
    EXPECT_TRUE(found->unknown.empty());
  }
}

TEST(LearntRanges, areTheSameObjectWhileNothingIsNew) {
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 1);
  Learning learning(*source);
  const auto first = learning.learnt.ranges();
  EXPECT_EQ(learning.learnt.ranges(), first);
  learning.read({3});
  const auto second = learning.learnt.ranges();
  EXPECT_NE(second, first);
  EXPECT_TRUE(second->isKnown(3));
  EXPECT_FALSE(second->isKnown(4));
  learning.read({3});
  EXPECT_EQ(learning.learnt.ranges(), second);
}

// Nobody has asked the source which blocks are empty: the listing comes later, and takes nothing
// away that was learnt before.
TEST(LearntRanges, areTheSameWhetherTheListingComesFirstOrLast) {
  const Box3 stored{{8, 8, 8}, {60, 30, 30}};
  FunctionSource source(
      functionLayout({80, 40, 40}, VoxelType::kU8),
      [&](int64_t, Vec3i v) {
        if (!stored.contains({v, v + Vec3i{1, 1, 1}})) return 5.0;
        return v.x < 30 ? 0.0 : 100.0 + static_cast<double>(v.y);
      },
      Occupancy{5, {stored}});
  const BlockLayout layout = blockLayout(source.layout().dims, 16, 2);
  const auto later =
      std::make_shared<const SliceRanges>(unknownRanges(source, 0, layout, Listing::kLater));
  EXPECT_EQ(static_cast<int64_t>(later->unknown.size()), layout.blockCount());
  EXPECT_FALSE(later->is_listed);
  LearntRanges learnt(0, later);
  Learning listed_first(source);
  EXPECT_LT(static_cast<int64_t>(listed_first.learnt.ranges()->unknown.size()),
            layout.blockCount());
  const std::vector<int64_t> read{0, 1, 2, layout.idOf({1, 1, 1}), layout.idOf({3, 1, 1})};
  listed_first.read(read);
  VolumeBuffer buffer(source, layout, uint64_t{1} << 28);
  for (const int64_t block : read) {
    const BlockName name{.block = block};
    learnt.note(name, *buffer.acquire(std::span(&name, 1)).front());
  }
  EXPECT_EQ(learnt.ranges()->unknown.size(), later->unknown.size() - read.size());
  EXPECT_EQ(learnt.ranges()->blocks.size(), read.size()) << "nothing is known to be background";
  const auto listed = listedRanges(learnt.ranges(), source, 0);
  const auto expected = listed_first.learnt.ranges();
  EXPECT_TRUE(listed->is_listed);
  EXPECT_EQ(listed->background, 5);
  EXPECT_EQ(listed->unknown, expected->unknown);
  for (int64_t block = 0; block < layout.blockCount(); ++block)
    EXPECT_EQ(listed->isKnown(block), expected->isKnown(block)) << block;
  EXPECT_EQ(listedRanges(listed, source, 0), listed);
}

TEST(LearntRanges, ignoreOtherLevelsAndSteps) {
  const auto source = makeWhiteNoise({40, 40, 40}, VoxelType::kU8, 1);
  Learning learning(*source);
  VolumeBuffer buffer(*source, learning.layout, uint64_t{1} << 28);
  const BlockName name{.block = 2};
  const auto block = buffer.acquire(std::span(&name, 1)).front();
  const auto before = learning.learnt.ranges();
  learning.learnt.note({.level = 1, .block = 2}, *block);
  learning.learnt.note({.time = 1, .block = 2}, *block);
  EXPECT_EQ(learning.learnt.ranges(), before);
}

}  // namespace
}  // namespace sluice
