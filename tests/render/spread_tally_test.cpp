// What is noted of the spreads of blocks.
#include "src/render/blocks/losses/spread_tally.h"

#include <gtest/gtest.h>

#include <cstring>

namespace sluice {
namespace {

// A block of two voxels with these spreads.
VolumeBlock blockWithSpreads(uint8_t a, uint8_t b) {
  VolumeBlock block;
  block.voxels = {{0, 0, 0}, {2, 1, 1}};
  block.numbers = 2;
  block.bytes = std::make_shared<std::byte[]>(block.byteCount());
  const uint8_t numbers[] = {1, 1, a, b};
  std::memcpy(block.bytes.get(), numbers, sizeof numbers);
  return block;
}

BlockName blockName(int64_t block) {
  BlockName name;
  name.level = 1;
  name.block = block;
  return name;
}

VisibleBlocks shown(int64_t block) {
  VisibleBlocks blocks;
  ObjectBlock object;
  object.name = blockName(block);
  object.cells = {{0, 0, 0}, {2, 2, 2}};
  blocks.blocks.push_back(object);
  return blocks;
}

TEST(SpreadTally, tellsTheLargestAndMeanSpreadOfAPicture) {
  SpreadTally tally;
  tally.note(blockName(3), blockWithSpreads(4, 10));
  const auto spread = tally.of(shown(3), 2);
  ASSERT_TRUE(spread);
  EXPECT_EQ(spread->largest, 20);
  EXPECT_EQ(spread->mean, 14);
  EXPECT_FALSE(tally.of(shown(4), 2));
}

TEST(SpreadTally, forgetsBlocksOverItsLimit) {
  SpreadTally tally;
  const VolumeBlock block = blockWithSpreads(4, 10);
  const auto most = static_cast<int64_t>(SpreadTally::kMostBlocks);
  for (int64_t i = 0; i < most; ++i) tally.note(blockName(i), block);
  tally.note(blockName(0), block);
  EXPECT_TRUE(tally.of(shown(0), 1)) << "a block that is read again takes no room";
  EXPECT_TRUE(tally.of(shown(most - 1), 1));
  tally.note(blockName(most), block);
  EXPECT_FALSE(tally.of(shown(0), 1));
  EXPECT_TRUE(tally.of(shown(most), 1));
}

}  // namespace
}  // namespace sluice
