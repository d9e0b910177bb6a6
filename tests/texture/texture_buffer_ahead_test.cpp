// A texture buffer that fills chunks ahead of its caller: batches begun, finished, cancelled.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <random>
#include <thread>

#include "src/base/error.h"
#include "src/texture/texture_buffer.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/texture/texture_buffer_fixture.h"

namespace sluice {
namespace {

using testing::IsEmpty;

TEST_F(TextureBufferTest, whatWasBegunIsThereWhenItIsAskedFor) {
  const auto buffer = bufferOf(counted_, 24);
  const auto first = buffer->begin(plan_, names_, chunksOf({0, 1, 2}));
  const auto second = buffer->begin(plan_, names_, chunksOf({2, 3}));
  const auto last = buffer->finish(second);
  expectTexels(plan_, ChunkPosition(int64_t{2}), *last[0], *memory_);
  expectTexels(plan_, ChunkPosition(int64_t{3}), *last[1], *memory_);
  EXPECT_EQ(buffer->finish(first)[2], last[0]);
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.loads, 4U);
  EXPECT_EQ(c.hits + c.coalesced, 1U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, aheadIsNotBegunWithoutRoom) {
  const auto buffer = bufferOf(counted_, 3);
  const auto first = buffer->begin(plan_, names_, chunksOf({0, 1}));
  EXPECT_EQ(buffer->tryBegin(plan_, names_, chunksOf({2, 3})), nullptr);
  const auto second = buffer->tryBegin(plan_, names_, chunksOf({1, 2}));
  ASSERT_NE(second, nullptr);  // 1 is under way already
  EXPECT_THROW(buffer->begin(plan_, names_, chunksOf({4})), Error);
  buffer->finish(first);
  buffer->finish(second);
  EXPECT_NE(buffer->begin(plan_, names_, chunksOf({4, 5, 6})), nullptr);
  EXPECT_EQ(buffer->counters().peak_bytes, 3 * kChunkBytes);
}

TEST_F(TextureBufferTest, cancelledChunksAreNotReadAndCanBeAskedForAgain) {
  std::promise<void> go;
  std::shared_future<void> may_go = go.get_future().share();
  FunctionSource stalled(memory_->layout(), [&](int64_t, Vec3i) -> double {
    may_go.wait();
    return 7;
  });
  const auto buffer = bufferOf(stalled, 24);
  // A pool of 2 has one worker: it stalls in the first block, the rest is not begun.
  const auto batch = buffer->begin(plan_, names_, chunksOf({0, 4, 8, 12, 16}));
  while (blocks_->counters().requests == 0) std::this_thread::yield();
  buffer->cancel(batch);
  go.set_value();
  const auto texels = acquire(*buffer, {4, 8, 0});
  EXPECT_EQ(texels[0]->bytes[0], std::byte{7});
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.failures, 4U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(blocks_->counters().loads, 3U);  // the one under way and the two asked for again
}

TEST_F(TextureBufferTest, aFailureAheadSurfacesWhereItIsAskedFor) {
  FailingSource failing(counted_, FailingSource::Failure::kError, 0);
  const auto buffer = bufferOf(failing, 24);
  const auto ahead = buffer->begin(plan_, names_, chunksOf({0}));
  EXPECT_THROW(buffer->finish(ahead), Error);
  EXPECT_EQ(acquire(*buffer, {0}).size(), 1U);
}

TEST_F(TextureBufferTest, destructionWaitsForWhatIsUnderWay) {
  for (int i = 0; i < 50; ++i) {
    const auto buffer = bufferOf(counted_, 24);
    const auto batch = buffer->begin(plan_, names_, allChunks(plan_));
    buffer->cancel(batch);
  }
}

TEST_F(TextureBufferTest, batchesBegunFinishedAndCancelledAtRandomKeepBudgetAndTexels) {
  WorkerPool many(5);
  for (uint32_t seed = 0; seed < 4; ++seed) {
    blocks_ = std::make_unique<VolumeBuffer>(counted_, layout_, 20 * kChunkBytes,
                                             VolumeBuffer::Cold::kPacked);
    TextureBuffer buffer(*blocks_, many, 9 * kChunkBytes);
    std::mt19937 random(seed);
    struct Begun {
      std::vector<ChunkPosition> chunks;
      TextureBuffer::BatchPtr batch;
    };
    std::vector<Begun> begun;
    const auto takeOne = [&] {
      const size_t which = random() % begun.size();
      Begun taken = std::move(begun[which]);
      begun.erase(begun.begin() + static_cast<ptrdiff_t>(which));
      return taken;
    };
    for (int i = 0; i < 600; ++i) {
      std::vector<ChunkPosition> chunks(1 + random() % 3), soon(random() % 5);
      for (ChunkPosition& chunk : chunks) chunk = ChunkPosition(random() % plan_.chunks.size());
      for (ChunkPosition& chunk : soon) chunk = ChunkPosition(random() % plan_.chunks.size());
      const auto batch = buffer.tryBegin(plan_, names_, chunks, soon);
      if (batch != nullptr) begun.push_back({chunks, batch});
      if (!begun.empty() && random() % 3 == 0) buffer.cancel(takeOne().batch);
      if (!begun.empty() && random() % 2 == 0) {
        const Begun taken = takeOne();
        const auto texels = buffer.finish(taken.batch);
        expectTexels(plan_, taken.chunks[0], *texels[0], *memory_);
        if (HasFatalFailure()) return;
      }
      ASSERT_LE(buffer.counters().current_bytes, 9 * kChunkBytes);
    }
    for (const Begun& rest : begun) buffer.cancel(rest.batch);
    buffer.waitUntilIdle();
    EXPECT_THAT(buffer.counters().brokenIdentity(), IsEmpty());
    EXPECT_THAT(blocks_->counters().brokenIdentity(), IsEmpty());
    EXPECT_LE(buffer.counters().peak_bytes, 9 * kChunkBytes);
    EXPECT_LE(blocks_->counters().peak_bytes, 20 * kChunkBytes);
  }
}

}  // namespace
}  // namespace sluice
