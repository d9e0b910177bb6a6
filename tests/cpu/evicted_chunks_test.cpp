// Chunks that leave the CPU device and stay in the level below, as many small ones of a frame do.
#include <gtest/gtest.h>

#include <vector>

#include "tests/cpu/test_device.h"
#include "tests/device/one_box.h"

namespace sluice {
namespace {

// The device keeps what it knows of each. If it looked at all of them whenever one leaves, these
// would take longer than a test may.
TEST(EvictedChunks, takeTimeInProportionToTheirNumber) {
  constexpr uint64_t kChunks = 100'000, kTurns = 3'000'000;
  const FrameSetup setup = setupOf({8, 8});
  TestCpuDevice device;
  std::vector<ChunkTexelsPtr> below;
  std::vector<BoxDraw> boxes(kChunks);
  below.reserve(kChunks);
  for (uint64_t id = 0; id < kChunks; ++id) {
    below.push_back(chunkTexels({2, 2, 2}, DeviceType::kU8,
                                std::vector<std::byte>(8, static_cast<std::byte>(id % 200))));
    device.makeResident(id, below.back());
    boxes[id].chunk = id;
    boxes[id].cells = boxOf({1, 1, 1});
  }
  const auto drawAll = [&] {
    device.beginFrame(setup);
    device.draw(boxes);
    return device.endFrame();
  };
  const Picture before = drawAll();
  for (uint64_t id = 0; id < kChunks; ++id) device.evict(id);
  for (uint64_t turn = 0; turn < kTurns; ++turn) {
    device.makeResident(turn % kChunks, below[turn % kChunks]);
    device.evict(turn % kChunks);
  }
  for (uint64_t id = 0; id < kChunks; ++id) device.makeResident(id, below[id]);
  EXPECT_EQ(drawAll().rgba, before.rgba);
}

}  // namespace
}  // namespace sluice
