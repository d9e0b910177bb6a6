#include "src/volume/volume_buffer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <future>
#include <map>
#include <numeric>
#include <random>
#include <thread>

#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// A volume of 4 x 3 x 2 whole blocks of 8^3 bytes, 512 B each.
constexpr Vec3i kDims{4 * 7 + 1, 3 * 7 + 1, 2 * 7 + 1};
constexpr uint64_t kBlockBytes = 512;

std::vector<BlockKey> keysOf(std::initializer_list<int64_t> blocks, int64_t time = 0) {
  std::vector<BlockKey> keys;
  for (const int64_t block : blocks) keys.push_back({time, block});
  return keys;
}

class VolumeBufferTest : public testing::Test {
 protected:
  std::unique_ptr<VolumeBuffer> bufferOf(VolumeSource& source, uint64_t blocks) {
    return std::make_unique<VolumeBuffer>(source, layout_, blocks * kBlockBytes);
  }
  Box3 storedBox(int64_t block) const { return layout_.storedVoxels(layout_.indexOf(block)); }

  const BlockLayout layout_ = blockLayout(kDims, 8, 0);
  const std::unique_ptr<MemorySource> memory_ = makeWhiteNoise(kDims, VoxelType::kU8, 1);
  CountingSource counted_{*memory_};
};

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
      std::vector<BlockKey> keys;
      for (int64_t block = 0; block < layout.blockCount(); ++block) keys.push_back({0, block});
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

// --- several threads

TEST_F(VolumeBufferTest, onlyOneThreadLoadsABlock) {
  FailingSource stalled(counted_, FailingSource::Failure::kStall, 0);
  const auto buffer = bufferOf(stalled, 4);
  auto first = std::async(std::launch::async, [&] { return buffer->acquire(keysOf({0, 1})); });
  stalled.waitUntilStalled();
  std::vector<std::future<std::vector<VolumeBlockPtr>>> others;
  for (int i = 0; i < 3; ++i)
    others.push_back(std::async(std::launch::async, [&] {
      return buffer->acquire(keysOf({1, 0}));
    }));
  while (buffer->counters().coalesced < 6) std::this_thread::yield();
  stalled.release();
  const auto blocks = first.get();
  for (auto& other : others) {
    const auto got = other.get();
    EXPECT_EQ(got[0], blocks[1]);
    EXPECT_EQ(got[1], blocks[0]);
  }
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.requests, 8U);
  EXPECT_EQ(c.misses, 8U);
  EXPECT_EQ(c.loads, 2U);
  EXPECT_EQ(c.coalesced, 6U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(counted_.counts().voxels, 2 * 512);  // however the two were read
}

TEST_F(VolumeBufferTest, othersGoOnWhileABlockIsLoading) {
  FailingSource stalled(counted_, FailingSource::Failure::kStall, 0);
  const auto buffer = bufferOf(stalled, 4);
  auto slow = std::async(std::launch::async, [&] { return buffer->acquire(keysOf({0})); });
  stalled.waitUntilStalled();
  EXPECT_EQ(buffer->acquire(keysOf({5}))[0]->voxels, storedBox(5));
  EXPECT_EQ(buffer->acquire(keysOf({5}))[0]->voxels, storedBox(5));
  stalled.release();
  EXPECT_EQ(slow.get()[0]->voxels, storedBox(0));
}

TEST_F(VolumeBufferTest, aLoadUnderWayHasItsRoomReserved) {
  FailingSource stalled(counted_, FailingSource::Failure::kStall, 0);
  const auto buffer = bufferOf(stalled, 1);
  auto slow = std::async(std::launch::async, [&] { return buffer->acquire(keysOf({0})); });
  stalled.waitUntilStalled();
  EXPECT_THROW(buffer->acquire(keysOf({5})), Error);
  stalled.release();
  EXPECT_EQ(slow.get()[0]->voxels, storedBox(0));
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

TEST_F(VolumeBufferTest, aFailedLoadReachesAllWhoWaitForIt) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "ThreadSanitizer does not see how the C++ library counts users of an exception";
#endif
  FailingSource failing(counted_, FailingSource::Failure::kError, 0);
  FailingSource stalled(failing, FailingSource::Failure::kStall, 0);
  const auto buffer = bufferOf(stalled, 4);
  const auto attempt = [&] {
    try {
      buffer->acquire(keysOf({0}));
      return std::string("no error");
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  auto first = std::async(std::launch::async, attempt);
  stalled.waitUntilStalled();
  auto second = std::async(std::launch::async, attempt);
  while (buffer->counters().coalesced < 1) std::this_thread::yield();
  stalled.release();
  EXPECT_THAT(first.get(), HasSubstr("fails as asked"));
  EXPECT_THAT(second.get(), HasSubstr("fails as asked"));
  CacheCounters c = buffer->counters();
  EXPECT_EQ(c.failures, 1U);
  EXPECT_EQ(c.coalesced, 1U);
  EXPECT_EQ(c.resident, 0U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(attempt(), "no error");
  c = buffer->counters();
  EXPECT_EQ(c.loads, 1U);
  EXPECT_EQ(c.redundant_loads, 0U);  // it had never been resident
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

// What threads hold at this moment, by block.
class HeldBlocks {
 public:
  explicit HeldBlocks(const VolumeBuffer& buffer) : buffer_(buffer) {}
  // False when the buffer accounts for less than what is held.
  bool hold(std::span<const BlockKey> keys) {
    const std::lock_guard lock(mutex_);
    for (const BlockKey& key : keys) ++counts_[key.block];
    return counts_.size() * kBlockBytes <= buffer_.counters().current_bytes;
  }
  void release(std::span<const BlockKey> keys) {
    const std::lock_guard lock(mutex_);
    for (const BlockKey& key : keys)
      if (--counts_[key.block] == 0) counts_.erase(key.block);
  }

 private:
  const VolumeBuffer& buffer_;
  std::mutex mutex_;
  std::map<int64_t, int> counts_;  // guarded by mutex_
};

TEST_F(VolumeBufferTest, budgetHoldsUnderManyThreads) {
  constexpr int kThreads = 8, kRounds = 300;
  // Room for what all threads may hold at once, and no more.
  const auto buffer = bufferOf(counted_, 2 * kThreads);
  HeldBlocks held(*buffer);
  std::vector<std::thread> threads;
  std::atomic<int> unaccounted{0}, wrong{0};
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t));
      for (int round = 0; round < kRounds; ++round) {
        const auto a = static_cast<int64_t>(random() % 24), b = static_cast<int64_t>(random() % 24);
        const auto keys = a == b ? keysOf({a}) : keysOf({a, b});
        auto blocks = buffer->acquire(keys);
        if (!held.hold(keys)) ++unaccounted;
        for (size_t i = 0; i < keys.size(); ++i) {
          const Vec3i corner = blocks[i]->voxels.hi - Vec3i{1, 1, 1};
          const int64_t at = (corner.z * kDims.y + corner.y) * kDims.x + corner.x;
          if (*blocks[i]->at(corner) != memory_->bytes()[static_cast<size_t>(at)]) ++wrong;
        }
        if (buffer->counters().current_bytes > 2 * kThreads * kBlockBytes) ++unaccounted;
        held.release(keys);
        blocks.clear();
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(unaccounted, 0);
  EXPECT_EQ(wrong, 0);
  const CacheCounters c = buffer->counters();
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(c.failures, 0U);
  EXPECT_LE(c.peak_bytes, c.budget_bytes);
  EXPECT_EQ(c.decoded_bytes, static_cast<uint64_t>(counted_.counts().bytes));
  EXPECT_GT(c.evictions, 0U);
}

TEST_F(VolumeBufferTest, aBlockThatSomeoneWaitsForIsNotEvicted) {
  // One block of room, three threads after three blocks: who waited for a load gets it without a
  // second one, or there is no room (an error), but never a block that is not accounted for.
  const auto buffer = bufferOf(counted_, 1);
  HeldBlocks held(*buffer);
  std::atomic<int> unaccounted{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t));
      for (int round = 0; round < 2000; ++round) {
        const auto keys = keysOf({static_cast<int64_t>(random() % 3)});
        try {
          const auto blocks = buffer->acquire(keys);
          if (!held.hold(keys)) ++unaccounted;
          held.release(keys);
        } catch (const Error&) {
          std::this_thread::yield();
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(unaccounted, 0);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  EXPECT_LE(buffer->counters().peak_resident, 1U);
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
