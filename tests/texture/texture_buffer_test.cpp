// A texture buffer returns the right texels, within the budget, and its counters tell what
// happened.
#include "src/texture/texture_buffer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "src/base/error.h"
#include "src/base/threads/stop_token.h"
#include "tests/support/failing_memory.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/texture/texture_buffer_fixture.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(TextureBufferTest, hitsAndMissesHaveTheNumbersOfTheirDefinition) {
  const auto buffer = bufferOf(counted_, 6);
  acquire(*buffer, {0, 1, 2, 3});   // 4 misses
  acquire(*buffer, {3, 2, 1, 0});   // 4 hits
  acquire(*buffer, {0, 4, 8, 12});  // 1 hit, 3 misses: 3 goes (least recently used)
  acquire(*buffer, {3});            // a miss, loaded before
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.requests, 13U);
  EXPECT_EQ(c.hits, 5U);
  EXPECT_EQ(c.misses, 8U);
  EXPECT_EQ(c.loads, 8U);
  EXPECT_EQ(c.redundant_loads, 1U);
  EXPECT_EQ(c.evictions, 2U);
  EXPECT_EQ(c.resident, 6U);
  EXPECT_EQ(c.current_bytes, 6 * kChunkBytes);
  EXPECT_EQ(c.peak_bytes, 6 * kChunkBytes);
  EXPECT_EQ(c.budget_bytes, 6 * kChunkBytes);
  EXPECT_EQ(c.decoded_bytes, 8 * kChunkBytes);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  // The level below, as second observer: each chunk is one block, and all blocks fit there.
  EXPECT_EQ(blocks_->counters().requests, 8U);
  EXPECT_EQ(blocks_->counters().loads, 7U);
}

TEST_F(TextureBufferTest, chunksComeInTheOrderAskedFor) {
  const auto buffer = bufferOf(counted_, 24);
  acquire(*buffer, {2, 7});
  const std::vector<int64_t> wanted{7, 0, 2, 23, 5};
  const auto texels = acquire(*buffer, wanted);
  for (size_t i = 0; i < wanted.size(); ++i) {
    expectTexels(plan_, ChunkPosition(wanted[i]), *texels[i], *memory_);
    if (HasFatalFailure()) FAIL() << "chunk " << wanted[i];
  }
}

TEST_F(TextureBufferTest, neighboursAlongXAreReadTogether) {
  const auto buffer = bufferOf(counted_, 24, 64);
  acquire(*buffer, {5, 2, 0, 3, 1, 4});
  EXPECT_EQ(counted_.counts().calls, 2);  // rows 0..3 and 4..5
}

// Rows of four blocks: for three threads half of level 2 is one block each, and all of it is no
// more than two rows at once.
TEST_F(TextureBufferTest, wholeRowsAreReadTogetherAlsoByFewerThreads) {
  const auto buffer = bufferOf(counted_, 24, 10);
  buffer->acquire(plan_, names_, allChunks(plan_));
  EXPECT_EQ(counted_.counts().calls, 6);
  EXPECT_LE(counted_.counts().max_at_once, 2);
}

TEST_F(TextureBufferTest, aPlanThatRepeatsARecipeFindsItsBytes) {
  const auto buffer = bufferOf(counted_, 24);
  buffer->acquire(plan_, names_, allChunks(plan_));
  buffer->resetCounters();
  counted_.reset();
  // The same but for one block, which is trimmed.
  VisibleBlocks changed = allBlack(layout_);
  changed.blocks[9] = objectBlock(layout_, 9, {{7, 14, 0}, {14, 21, 3}});
  const TexturePlan plan =
      planTextures(layout_, changed, page_, planOptions(layout_, Algorithm::kTrimmed));
  const auto texels = buffer->acquire(plan, chunk_names_.namesOf(plan), allChunks(plan));
  EXPECT_EQ(buffer->counters().hits, 23U);
  EXPECT_EQ(buffer->counters().loads, 1U);
  EXPECT_EQ(counted_.counts().calls, 0);  // its block is at level 2 still
  expectTexels(plan, ChunkPosition(int64_t{9}), *texels[9], *memory_);
}

TEST_F(TextureBufferTest, heldChunksStay) {
  const auto buffer = bufferOf(counted_, 3);
  auto held = acquire(*buffer, {0});
  for (const int64_t chunk : {1, 2, 3, 4, 5}) acquire(*buffer, {chunk});
  buffer->resetCounters();
  EXPECT_EQ(acquire(*buffer, {0})[0], held[0]);
  EXPECT_EQ(buffer->counters().hits, 1U);
}

TEST_F(TextureBufferTest, moreThanTheBudgetAtOnceIsAnErrorThatSaysHowMuch) {
  const auto buffer = bufferOf(counted_, 2);
  acquire(*buffer, {9});
  try {
    acquire(*buffer, {0, 1, 2});
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("1.0 KiB"), HasSubstr("--memory")));
  }
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  EXPECT_EQ(buffer->counters().failures, 3U);
  EXPECT_EQ(acquire(*buffer, {0, 1}).size(), 2U);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  EXPECT_LE(buffer->counters().peak_bytes, 2 * kChunkBytes);
}

TEST_F(TextureBufferTest, aFailedReadLeavesTheBufferUsable) {
  FailingSource failing(counted_, FailingSource::Failure::kError, 1);
  const auto buffer = bufferOf(failing, 24);
  EXPECT_THROW(acquire(*buffer, {0, 5, 10, 15}), Error);
  CacheCounters c = buffer->counters();
  EXPECT_GE(c.failures, 1U);
  EXPECT_EQ(c.resident, 4 - c.failures);  // chunks that other threads filled meanwhile are kept
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  const auto texels = acquire(*buffer, {0, 5, 10, 15});
  expectTexels(plan_, ChunkPosition(int64_t{5}), *texels[1], *memory_);
  c = buffer->counters();
  EXPECT_EQ(c.loads, 4U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_THAT(blocks_->counters().brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, anInterruptionPassesThrough) {
  FunctionSource source(memory_->layout(), [](int64_t, Vec3i) -> double { throw Interrupted(); });
  const auto buffer = bufferOf(source, 24);
  EXPECT_THROW(acquire(*buffer, {0, 1, 2}), Interrupted);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, oneChunkTwiceInACallIsLoadedOnce) {
  const auto buffer = bufferOf(counted_, 2);
  const auto texels = acquire(*buffer, {4, 4, 4});
  EXPECT_EQ(texels[0], texels[1]);
  EXPECT_EQ(texels[0], texels[2]);
  EXPECT_EQ(buffer->counters().loads, 1U);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  for (const int64_t chunk : {1, 2, 3, 4}) acquire(*buffer, {chunk});
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, budgetsOfBothLevelsHoldOverManyFrames) {
  constexpr uint64_t kChunks = 5, kBlocks = 4;
  const auto buffer = bufferOf(counted_, kChunks, kBlocks);
  std::mt19937 random(1);
  for (int frame = 0; frame < 200; ++frame) {
    std::vector<int64_t> wanted(1 + random() % kChunks);
    for (int64_t& chunk : wanted) chunk = static_cast<int64_t>(random() % plan_.chunks.size());
    const auto texels = acquire(*buffer, wanted);
    expectTexels(plan_, ChunkPosition(wanted[0]), *texels[0], *memory_);
    ASSERT_LE(buffer->counters().current_bytes, kChunks * kChunkBytes);
    ASSERT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  }
  EXPECT_LE(blocks_->counters().peak_bytes, kBlocks * kChunkBytes);
  EXPECT_THAT(blocks_->counters().brokenIdentity(), IsEmpty());
  EXPECT_GT(buffer->counters().evictions, 0U);
}

TEST_F(TextureBufferTest, whereMemoryRunsOutNoChunkIsLeftHalfDone) {
  forEachAllocation([&](int64_t n) {
    const auto buffer = bufferOf(*memory_, 6);
    acquire(*buffer, {0, 1, 2, 3});
    bool failed = false;
    {
      const FailingMemory memory(n);
      try {
        acquire(*buffer, {3, 4, 8, 12});
      } catch (const std::bad_alloc&) {
      }
      failed = memory.failed();
    }
    buffer->waitUntilIdle();
    EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
    for (const int64_t chunk : {12, 8, 4, 3}) {
      const auto texels = acquire(*buffer, {chunk});  // would wait for ever
      expectTexels(plan_, ChunkPosition(chunk), *texels[0], *memory_);
    }
    EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
    return failed;
  });
}

}  // namespace
}  // namespace sluice
