#include "src/volume/learnt_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "src/volume/volume_buffer.h"
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
    return buildSliceRanges(source, 0, layout, pool, progress);
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
