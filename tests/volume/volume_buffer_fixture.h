// A volume of blocks of one size and a VolumeBuffer over it, with a second observer of its reads.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>
#include <memory>
#include <vector>

#include "src/volume/volume_buffer.h"
#include "tests/support/counting_source.h"
#include "tests/support/random_volume.h"

namespace sluice {

// A volume of 4 x 3 x 2 whole blocks of 8^3 bytes, 512 B each.
inline constexpr Vec3i kDims{4 * 7 + 1, 3 * 7 + 1, 2 * 7 + 1};
inline constexpr uint64_t kBlockBytes = 512;

inline std::vector<BlockName> keysOf(std::initializer_list<int64_t> blocks, int64_t time = 0) {
  std::vector<BlockName> keys;
  for (const int64_t block : blocks) keys.push_back({.time = time, .block = block});
  return keys;
}

class VolumeBufferTest : public testing::Test {
 protected:
  // A buffer with room for `blocks`; `source` must outlive it.
  std::unique_ptr<VolumeBuffer> bufferOf(VolumeSource& source, uint64_t blocks) {
    return std::make_unique<VolumeBuffer>(source, layout_, blocks * kBlockBytes);
  }
  Box3 storedBox(int64_t block) const { return layout_.storedVoxels(layout_.indexOf(block)); }

  const BlockLayout layout_ = blockLayout(kDims, 8, 0);
  const std::unique_ptr<MemorySource> memory_ = makeWhiteNoise(kDims, VoxelType::kU8, 1);
  CountingSource counted_{*memory_};
};

}  // namespace sluice
