// A volume buffer used by one thread: the voxels that it hands out, how it reads them, and reads
// that fail.
#include "src/volume/volume_buffer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "src/base/error.h"
#include "src/base/threads/stop_token.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/volume/volume_buffer_fixture.h"

namespace sluice {
namespace {

using testing::IsEmpty;

// --- contents

TEST(VolumeBuffer, blocksHoldTheVoxelsOfTheSourceInDeviceForm) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI8, VoxelType::kU16, VoxelType::kI16,
                               VoxelType::kU32, VoxelType::kI32, VoxelType::kF32, VoxelType::kF64})
    for (const int ghost : {0, 1}) {
      const Vec3i dims{20, 17, 11};
      const auto source = makeWhiteNoise(dims, type, 7);
      const BlockLayout layout = blockLayout(dims, 8, ghost);
      const size_t stored_size = bytesPerVoxel(type);
      VolumeBuffer buffer(*source, layout, 1 << 20);
      std::vector<BlockName> keys;
      for (int64_t block = 0; block < layout.blockCount(); ++block)
        keys.push_back({.block = block});
      const std::vector<VolumeBlockPtr> blocks = buffer.acquire(keys);
      for (int64_t id = 0; id < layout.blockCount(); ++id) {
        const VolumeBlock& block = *blocks[static_cast<size_t>(id)];
        ASSERT_EQ(block.voxels, layout.storedVoxels(layout.indexOf(id)));
        const Box3 box = block.voxels;
        for (int64_t z = box.lo.z; z < box.hi.z; ++z)
          for (int64_t y = box.lo.y; y < box.hi.y; ++y)
            for (int64_t x = box.lo.x; x < box.hi.x; ++x) {
              const int64_t at = (z * dims.y + y) * dims.x + x;
              const auto stored =
                  source->bytes().subspan(static_cast<size_t>(at) * stored_size, stored_size);
              std::vector<std::byte> device(bytesPerVoxel(block.type));
              toDevice(type, stored, device);
              ASSERT_EQ(std::memcmp(block.at({x, y, z}), device.data(), device.size()), 0)
                  << name(type) << " block " << id;
            }
      }
    }
}

TEST_F(VolumeBufferTest, timeStepsAreDifferentBlocks) {
  VolumeLayout layout = memory_->layout();
  layout.time_steps = 2;
  FunctionSource source(layout, [](int64_t t, Vec3i) { return t == 0 ? 10.0 : 20.0; });
  const auto buffer = bufferOf(source, 4);
  const auto first = buffer->acquire(keysOf({3}, 0)), second = buffer->acquire(keysOf({3}, 1));
  EXPECT_EQ(first[0]->bytes[0], std::byte{10});
  EXPECT_EQ(second[0]->bytes[0], std::byte{20});
  EXPECT_EQ(buffer->counters().loads, 2U);
}

TEST_F(VolumeBufferTest, blocksComeInTheOrderAskedFor) {
  const auto buffer = bufferOf(counted_, 8);
  buffer->acquire(keysOf({2, 7}));
  const auto blocks = buffer->acquire(keysOf({7, 0, 2, 1, 5}));
  ASSERT_EQ(blocks.size(), 5U);
  size_t i = 0;
  for (const int64_t block : {7, 0, 2, 1, 5}) EXPECT_EQ(blocks[i++]->voxels, storedBox(block));
}

TEST_F(VolumeBufferTest, nothingAskedForIsNothing) {
  const auto buffer = bufferOf(counted_, 0);
  EXPECT_TRUE(buffer->acquire({}).empty());
  EXPECT_EQ(buffer->counters().requests, 0U);
}

// --- reads

TEST_F(VolumeBufferTest, neighboursAlongXAreReadTogether) {
  const auto buffer = bufferOf(counted_, 24);
  buffer->acquire(keysOf({0, 1, 2}));
  EXPECT_EQ(counted_.counts().calls, 1);
  EXPECT_EQ(counted_.reads(), (std::vector<CountingSource::Read>{
                                  {0, storedBox(0)}, {0, storedBox(1)}, {0, storedBox(2)}}));
}

TEST_F(VolumeBufferTest, aReadEndsWithTheRowAndTakesNoBlockOfAGap) {
  const auto buffer = bufferOf(counted_, 24);
  // 3 is the last of its row, 4 the first of the next; 6 is not there before 7.
  buffer->acquire(keysOf({2, 3, 4, 5, 7}));
  EXPECT_EQ(counted_.counts().calls, 2);
  EXPECT_EQ(counted_.reads(), (std::vector<CountingSource::Read>{{0, storedBox(2)},
                                                                 {0, storedBox(3)},
                                                                 {0, storedBox(4)},
                                                                 {0, storedBox(5)},
                                                                 {0, storedBox(7)}}));
}

TEST_F(VolumeBufferTest, residentBlocksAreNotReadAgain) {
  const auto buffer = bufferOf(counted_, 24);
  buffer->acquire(keysOf({1}));
  counted_.reset();
  buffer->acquire(keysOf({0, 1, 2}));
  EXPECT_EQ(counted_.counts().voxels, 2 * 512);
  EXPECT_EQ(counted_.timesRead(0, storedBox(0)), 1);
  EXPECT_EQ(counted_.timesRead(0, storedBox(2)), 1);
}

TEST(VolumeBuffer, voxelsThatShrinkGoThroughAScratchOfBoundedSize) {
  const Vec3i dims{127, 64, 60};
  const auto memory = makeMemorySource<double>(
      dims, [](auto x, auto y, auto z) { return static_cast<double>(x * 3 + y * 5 + z * 7); });
  CountingSource source(*memory);
  const BlockLayout layout = blockLayout(dims, 64, 0);
  VolumeBuffer buffer(source, layout, uint64_t{128} << 20);
  const auto blocks = buffer.acquire(keysOf({0, 1}));
  EXPECT_GT(source.counts().calls, 2);
  for (const CountingSource::Read& read : source.reads())
    EXPECT_LE(read.box.count() * 8, static_cast<int64_t>(VolumeBuffer::kScratchBytes));
  EXPECT_EQ(source.counts().voxels, 128 * 64 * 60);  // the plane between the blocks twice
  EXPECT_EQ(buffer.counters().decoded_bytes, static_cast<uint64_t>(source.counts().bytes));
  for (const auto& block : blocks)
    for (const Vec3i p : {block->voxels.lo, block->voxels.hi - Vec3i{1, 1, 1}, Vec3i{63, 10, 47},
                          Vec3i{63, 3, 59}}) {
      float voxel = 0;
      std::memcpy(&voxel, block->at(p), sizeof voxel);
      EXPECT_EQ(voxel, static_cast<float>(p.x * 3 + p.y * 5 + p.z * 7));
    }
}

// --- failures

TEST_F(VolumeBufferTest, failedBlocksAreNotKeptAndTriedAgain) {
  FailingSource failing(counted_, FailingSource::Failure::kError, 1);
  const auto buffer = bufferOf(failing, 8);
  // Three reads: the second one fails, the others come in.
  EXPECT_THROW(buffer->acquire(keysOf({0, 4, 8})), Error);
  CacheCounters c = buffer->counters();
  EXPECT_EQ(c.loads, 2U);
  EXPECT_EQ(c.failures, 1U);
  EXPECT_EQ(c.resident, 2U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(buffer->acquire(keysOf({0, 4, 8}))[1]->voxels, storedBox(4));
  c = buffer->counters();
  EXPECT_EQ(c.hits, 2U);
  EXPECT_EQ(c.loads, 3U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST_F(VolumeBufferTest, roomOfFailedBlocksIsGivenBack) {
  FailingSource failing(counted_, FailingSource::Failure::kError, 0, 10);
  const auto buffer = bufferOf(failing, 2);
  for (int attempt = 0; attempt < 5; ++attempt)
    EXPECT_THROW(buffer->acquire(keysOf({0, 4})), Error);
  EXPECT_EQ(buffer->acquire(keysOf({0, 4})).size(), 2U);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

TEST_F(VolumeBufferTest, othersExceptionsBecomeErrorsThatNameTheVolume) {
  VolumeLayout layout = memory_->layout();
  layout.name = "head.vdb";
  FunctionSource source(layout,
                        [](int64_t, Vec3i) -> double { throw std::runtime_error("bad leaf"); });
  const auto buffer = bufferOf(source, 2);
  try {
    buffer->acquire(keysOf({5}));
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "head.vdb: block 5: bad leaf");
  }
}

TEST_F(VolumeBufferTest, interruptionStaysAnInterruption) {
  FunctionSource source(memory_->layout(), [](int64_t, Vec3i) -> double { throw Interrupted(); });
  const auto buffer = bufferOf(source, 2);
  EXPECT_THROW(buffer->acquire(keysOf({5})), Interrupted);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

}  // namespace
}  // namespace sluice
