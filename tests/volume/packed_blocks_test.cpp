// Blocks that stay compressed in memory, against the voxels that they were made from.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <thread>

#include "src/volume/volume_buffer.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_memory.h"
#include "tests/support/random_volume.h"

namespace sluice::packed_blocks_test {
namespace {

using testing::IsEmpty;

std::vector<BlockName> keysOf(std::initializer_list<int64_t> blocks) {
  std::vector<BlockName> keys;
  for (const int64_t block : blocks) keys.push_back({.block = block});
  return keys;
}

class PackedBlocksTest : public testing::Test {
 protected:
  static constexpr Vec3i kSmooth{9 * 15 + 1, 2 * 15 + 1, 2 * 15 + 1};  // 36 blocks of 16^3
  static constexpr uint64_t kBytes = 16 * 16 * 16 * 2;
  std::unique_ptr<VolumeBuffer> bufferOf(VolumeSource& source, uint64_t blocks) {
    return std::make_unique<VolumeBuffer>(source, layout_, blocks * kBytes,
                                          VolumeBuffer::Cold::kPacked);
  }
  void expectVoxels(const VolumeBlock& block) const {
    std::vector<std::byte> expected(block.byteCount());
    memory_->readRegion(0, block.voxels, expected);
    EXPECT_EQ(std::memcmp(expected.data(), block.bytes.get(), expected.size()), 0);
  }

  const BlockLayout layout_ = blockLayout(kSmooth, 16, 0);
  const std::unique_ptr<MemorySource> memory_ = makeMemorySource<uint16_t>(
      kSmooth, [](auto x, auto y, auto z) { return static_cast<uint16_t>(x / 8 + y / 4 + z); });
  CountingSource counted_{*memory_};
};

TEST_F(PackedBlocksTest, reusedBlocksStayPackedWhereOnlyHalfWouldFitAsTheyAre) {
  const auto buffer = bufferOf(counted_, 18);
  for (int turn = 0; turn < 4; ++turn)
    for (int64_t block = 0; block < layout_.blockCount(); ++block)
      expectVoxels(*buffer->acquire(keysOf({block}))[0]);
  const CacheCounters c = buffer->counters();
  // The first turn reads all and keeps as much as fits; the second finds which blocks come back.
  EXPECT_LT(counted_.counts().voxels, 3 * layout_.blockCount() * 16 * 16 * 16);
  EXPECT_GT(c.packs, 0U);
  EXPECT_GT(c.unpacks, 0U);
  EXPECT_GT(c.hits, static_cast<uint64_t>(layout_.blockCount()));
  EXPECT_LE(c.peak_bytes, 18 * kBytes);
  EXPECT_GT(c.peak_resident, 18U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST_F(PackedBlocksTest, whatIsAskedForOnceIsDroppedUnpacked) {
  const auto buffer = bufferOf(counted_, 18);
  for (int64_t block = 0; block < layout_.blockCount(); ++block) buffer->acquire(keysOf({block}));
  EXPECT_EQ(buffer->counters().packs, 0U);
  EXPECT_GT(buffer->counters().evictions, 0U);
}

TEST_F(PackedBlocksTest, whatWasBroughtAheadAndThenUsedOnceIsDroppedUnpacked) {
  const auto buffer = bufferOf(counted_, 18);
  for (int64_t block = 0; block + 1 < layout_.blockCount(); ++block)
    buffer->acquire(keysOf({block, block + 1}), {false, true});
  EXPECT_EQ(counted_.counts().voxels, layout_.blockCount() * 16 * 16 * 16);
  EXPECT_GT(buffer->counters().evictions, 0U);
  EXPECT_EQ(buffer->counters().packs, 0U);
}

TEST_F(PackedBlocksTest, whatWasUsedBeforeItWasBroughtAheadCountsAsReused) {
  const auto buffer = bufferOf(counted_, 18);
  buffer->acquire(keysOf({0}));
  buffer->acquire(keysOf({0, 1}), {true, false});
  buffer->acquire(keysOf({0}));
  for (int64_t block = 2; block < layout_.blockCount(); ++block) buffer->acquire(keysOf({block}));
  EXPECT_EQ(buffer->counters().packs, 1U);
}

TEST_F(PackedBlocksTest, noiseIsDroppedRatherThanPacked) {
  const auto noise = makeWhiteNoise(kSmooth, VoxelType::kU16, 7);
  const auto buffer = bufferOf(*noise, 18);
  for (int turn = 0; turn < 3; ++turn)
    for (int64_t block = 0; block < layout_.blockCount(); ++block) buffer->acquire(keysOf({block}));
  EXPECT_EQ(buffer->counters().packs, 0U);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

TEST_F(PackedBlocksTest, budgetAndVoxelsHoldUnderManyThreads) {
  const auto buffer = bufferOf(counted_, 20);
  std::vector<std::thread> threads;
  for (uint32_t seed = 0; seed < 4; ++seed)
    threads.emplace_back([&, seed] {
      std::mt19937 random(seed);
      for (int i = 0; i < 400; ++i) {
        const auto first = static_cast<int64_t>(random() % 34);
        for (const auto& block : buffer->acquire(keysOf({first, first + 2}))) expectVoxels(*block);
      }
    });
  for (std::thread& thread : threads) thread.join();
  const CacheCounters c = buffer->counters();
  EXPECT_GT(c.unpacks, 0U);
  EXPECT_LE(c.peak_bytes, 20 * kBytes);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

// A failure may hit a block when it is published, packed or unpacked: threads that wait for it must
// not wait for ever.
TEST_F(PackedBlocksTest, whereMemoryRunsOutNoBlockIsLeftHalfDone) {
  forEachAllocation([&](int64_t n) {
    const auto buffer = bufferOf(*memory_, 18);
    const auto visitAll = [&] {
      for (int64_t block = 0; block + 1 < layout_.blockCount(); block += 2)
        buffer->acquire(keysOf({block, block + 1}));
    };
    visitAll();
    visitAll();
    visitAll();
    EXPECT_GT(buffer->counters().packs, 0U);
    bool failed = false;
    {
      const FailingMemory memory(n);
      try {
        buffer->acquire(keysOf({0, 7, 35}));
        buffer->acquire(keysOf({34, 1, 12}));
      } catch (const std::bad_alloc&) {
      }
      failed = memory.failed();
    }
    EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
    for (int64_t block = 0; block < layout_.blockCount(); ++block)
      expectVoxels(*buffer->acquire(keysOf({block}))[0]);
    EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
    return failed;
  });
}

}  // namespace
}  // namespace sluice::packed_blocks_test
