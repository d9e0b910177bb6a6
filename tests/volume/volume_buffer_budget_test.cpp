// A volume buffer within its budget: resident blocks, hits, misses and evictions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <list>
#include <random>

#include "src/base/error.h"
#include "src/volume/volume_buffer.h"
#include "tests/volume/volume_buffer_fixture.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// --- accounting

TEST_F(VolumeBufferTest, hitsAndMissesHaveTheNumbersOfTheirDefinition) {
  const auto buffer = bufferOf(counted_, 6);
  buffer->acquire(keysOf({0, 1, 2, 3}));   // 4 misses
  buffer->acquire(keysOf({3, 2, 1, 0}));   // 4 hits
  buffer->acquire(keysOf({0, 4, 8, 12}));  // 1 hit, 3 misses: 1 more than fits, 3 goes (LRU)
  buffer->acquire(keysOf({3}));            // a miss, loaded before
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.requests, 13U);
  EXPECT_EQ(c.hits, 5U);
  EXPECT_EQ(c.misses, 8U);
  EXPECT_EQ(c.loads, 8U);
  EXPECT_EQ(c.redundant_loads, 1U);
  EXPECT_EQ(c.coalesced, 0U);
  EXPECT_EQ(c.failures, 0U);
  EXPECT_EQ(c.evictions, 2U);
  EXPECT_EQ(c.resident, 6U);
  EXPECT_EQ(c.peak_resident, 6U);
  EXPECT_EQ(c.current_bytes, 6 * kBlockBytes);
  EXPECT_EQ(c.peak_bytes, 6 * kBlockBytes);
  EXPECT_EQ(c.budget_bytes, 6 * kBlockBytes);
  EXPECT_EQ(c.loaded_bytes, 8 * kBlockBytes);
  EXPECT_EQ(c.evicted_bytes, 2 * kBlockBytes);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  // The second observer.
  EXPECT_EQ(counted_.counts().bytes, 8 * 512);
  EXPECT_EQ(c.decoded_bytes, static_cast<uint64_t>(counted_.counts().bytes));
}

TEST_F(VolumeBufferTest, borderBlocksCountWhatExistsOfThem) {
  const auto source = makeWhiteNoise({10, 9, 8}, VoxelType::kI16, 1);
  const BlockLayout layout = blockLayout({10, 9, 8}, 8, 0);  // 2 x 2 x 1 blocks
  VolumeBuffer buffer(*source, layout, 1 << 20);
  EXPECT_EQ(buffer.blockBytes(), 1024U);
  buffer.acquire(keysOf({0, 1, 2, 3}));
  EXPECT_EQ(buffer.counters().current_bytes, 2U * 8 * (8 * 8 + 3 * 8 + 8 * 2 + 3 * 2));
}

TEST_F(VolumeBufferTest, resetForgetsEventsAndKeepsOccupancy) {
  const auto buffer = bufferOf(counted_, 6);
  buffer->acquire(keysOf({0, 1, 2}));
  buffer->resetCounters();
  CacheCounters c = buffer->counters();
  EXPECT_EQ(c.requests, 0U);
  EXPECT_EQ(c.resident, 3U);
  EXPECT_EQ(c.current_bytes, 3 * kBlockBytes);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  buffer->acquire(keysOf({2, 3}));
  c = buffer->counters();
  EXPECT_EQ(c.hits, 1U);
  EXPECT_EQ(c.loads, 1U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

// --- eviction

TEST_F(VolumeBufferTest, evictsLeastRecentlyUsed) {
  // Against a list kept by hand, on random requests.
  constexpr size_t kCapacity = 5;
  const auto buffer = bufferOf(counted_, kCapacity);
  std::list<int64_t> recent;
  uint64_t hits = 0;
  std::mt19937 random(3);
  for (int request = 0; request < 2000; ++request) {
    const auto block = static_cast<int64_t>(random() % 9);
    buffer->acquire(keysOf({block}));
    const auto found = std::find(recent.begin(), recent.end(), block);
    if (found != recent.end()) {
      ++hits;
      recent.erase(found);
    }
    recent.push_front(block);
    if (recent.size() > kCapacity) recent.pop_back();
    ASSERT_EQ(buffer->counters().hits, hits) << "request " << request;
  }
  EXPECT_EQ(counted_.counts().calls, static_cast<int64_t>(2000 - hits));
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

// Two levels, the coarser one of a single block.
class LeveledBufferTest : public VolumeBufferTest {
 protected:
  static constexpr uint64_t kRoom = 40;  // blocks
  BlockName coarse(int64_t time = 0) const { return {.time = time, .level = 1, .block = 0}; }
  // More blocks of level 0, of this step and the next, than there is room for.
  void fill(VolumeBuffer& buffer, int64_t time = 0) {
    for (int64_t block = 0; block < 24; ++block) buffer.acquire(keysOf({block}, time));
    for (int64_t block = 0; block < 24; ++block) buffer.acquire(keysOf({block}, time + 1));
  }

  const std::unique_ptr<MemorySource> fine_ = makeSparseBlobs({.dims = kDims, .time_steps = 4}),
                                      coarse_ =
                                          makeSparseBlobs({.dims = {8, 8, 8}, .time_steps = 4});
  const BlockLayout coarse_layout_ = blockLayout({8, 8, 8}, 8, 0);
  CountingSource fine_counted_{*fine_}, coarse_counted_{*coarse_};
};

TEST_F(LeveledBufferTest, theCoarsestLevelOfTheStepInUseGoesLast) {
  VolumeBuffer buffer({{&fine_counted_, layout_}, {&coarse_counted_, coarse_layout_}},
                      kRoom * kBlockBytes);
  buffer.acquire(std::array{coarse(1)});
  fill(buffer);
  buffer.acquire(std::array{coarse(1)});
  EXPECT_EQ(coarse_counted_.counts().calls, 1);
  // A step that is no longer drawn gives its blocks up.
  fill(buffer, 2);
  buffer.acquire(std::array{coarse(1)});
  EXPECT_EQ(coarse_counted_.counts().calls, 2);
  EXPECT_THAT(buffer.counters().brokenIdentity(), IsEmpty());
}

TEST_F(LeveledBufferTest, theCoarsestLevelGoesIfNothingElseCan) {
  VolumeBuffer buffer({{&fine_counted_, layout_}, {&coarse_counted_, coarse_layout_}},
                      8 * kBlockBytes);
  buffer.acquire(std::array{coarse()});
  const auto held = buffer.acquire(keysOf({0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(held.size(), 8U);
  buffer.acquire(std::array{BlockName{.block = 0}});
}

TEST_F(LeveledBufferTest, aBlockThatMakesRoomForACoarserOneIsKeptCompressed) {
  VolumeBuffer buffer({{&fine_counted_, layout_}, {&coarse_counted_, coarse_layout_}},
                      16 * kBlockBytes, VolumeBuffer::Cold::kPacked);
  for (int64_t block = 0; block < 15; ++block) buffer.acquire(keysOf({block}));
  const int64_t read = fine_counted_.counts().calls;
  buffer.acquire(std::array{coarse()});
  buffer.acquire(keysOf({0}));  // the coldest
  EXPECT_EQ(fine_counted_.counts().calls, read);
}

TEST_F(VolumeBufferTest, heldBlocksStay) {
  const auto buffer = bufferOf(counted_, 3);
  auto held = buffer->acquire(keysOf({0}));
  for (const int64_t block : {1, 2, 3, 4, 5, 6}) buffer->acquire(keysOf({block}));
  buffer->resetCounters();
  EXPECT_EQ(buffer->acquire(keysOf({0}))[0], held[0]);
  EXPECT_EQ(buffer->counters().hits, 1U);
  held.clear();
  for (const int64_t block : {7, 8, 9}) buffer->acquire(keysOf({block}));
  buffer->acquire(keysOf({0}));
  EXPECT_EQ(buffer->counters().redundant_loads, 1U);
}

TEST_F(VolumeBufferTest, saysHowMuchIsMissingWhenAllIsHeld) {
  const auto buffer = bufferOf(counted_, 2);
  auto held = buffer->acquire(keysOf({0, 5}));
  try {
    buffer->acquire(keysOf({9}));
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("1.0 KiB"), HasSubstr("512 B"), HasSubstr("--memory")));
  }
  CacheCounters c = buffer->counters();
  EXPECT_EQ(c.failures, 1U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  held.pop_back();
  EXPECT_EQ(buffer->acquire(keysOf({9}))[0]->voxels, storedBox(9));
  EXPECT_EQ(buffer->counters().evictions, 1U);
}

TEST_F(VolumeBufferTest, moreThanTheBudgetAtOnceIsAnErrorAndLeavesTheBufferUsable) {
  const auto buffer = bufferOf(counted_, 2);
  EXPECT_THROW(buffer->acquire(keysOf({0, 1, 2})), Error);
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.misses, 3U);
  EXPECT_EQ(c.loads, 2U);
  EXPECT_EQ(c.failures, 1U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(buffer->acquire(keysOf({2, 3})).size(), 2U);
  EXPECT_EQ(bufferOf(counted_, 0)->counters().budget_bytes, 0U);
}

TEST_F(VolumeBufferTest, zeroBudgetHoldsNothing) {
  const auto buffer = bufferOf(counted_, 0);
  EXPECT_THROW(buffer->acquire(keysOf({0})), Error);
  EXPECT_EQ(counted_.counts().calls, 0);
  EXPECT_EQ(buffer->counters().current_bytes, 0U);
}

TEST_F(VolumeBufferTest, oneCallDoesNotEvictWhatItHasFound) {
  const auto buffer = bufferOf(counted_, 2);
  buffer->acquire(keysOf({0}));
  buffer->acquire(keysOf({4}));
  // 0 is the least recently used one, but wanted; 4 is not.
  EXPECT_EQ(buffer->acquire(keysOf({0, 8}))[0]->voxels, storedBox(0));
  EXPECT_EQ(counted_.timesRead(0, storedBox(0)), 1);
}

TEST_F(VolumeBufferTest, handlesOutliveTheBuffer) {
  auto buffer = bufferOf(counted_, 2);
  const auto held = buffer->acquire(keysOf({0}));
  buffer.reset();
  EXPECT_EQ(held[0]->bytes[0], memory_->bytes()[0]);
}

}  // namespace
}  // namespace sluice
