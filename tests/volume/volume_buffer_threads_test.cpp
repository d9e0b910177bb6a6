// A volume buffer used by several threads: which loads, which wait, and that the budget holds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "src/base/error.h"
#include "src/volume/volume_buffer.h"
#include "tests/support/failing_source.h"
#include "tests/volume/volume_buffer_fixture.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

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

// The blocks that threads hold at this moment.
class HeldBlocks {
 public:
  explicit HeldBlocks(const VolumeBuffer& buffer) : buffer_(buffer) {}
  // False when the buffer accounts for fewer bytes than are held.
  bool hold(std::span<const BlockName> keys) {
    const std::lock_guard lock(mutex_);
    for (const BlockName& key : keys) ++counts_[key.block];
    return counts_.size() * kBlockBytes <= buffer_.counters().current_bytes;
  }
  void release(std::span<const BlockName> keys) {
    const std::lock_guard lock(mutex_);
    for (const BlockName& key : keys)
      if (--counts_[key.block] == 0) counts_.erase(key.block);
  }

 private:
  const VolumeBuffer& buffer_;
  std::mutex mutex_;
  std::map<int64_t, int> counts_;  // guarded by mutex_
};

TEST_F(VolumeBufferTest, budgetHoldsUnderManyThreads) {
  constexpr int kThreads = 8, kRounds = 300;
  // Room for everything that all threads may hold at once, and no more.
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
  // Room for one block, and three threads after three blocks. A thread that waited for a load gets
  // the block without a second load, or an error because there is no room, but never a block that
  // is not accounted for.
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

}  // namespace
}  // namespace sluice
