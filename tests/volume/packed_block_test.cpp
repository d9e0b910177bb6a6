#include "src/volume/packed_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <vector>

#include "tests/support/memory_peak.h"

namespace sluice {
namespace {

std::vector<std::byte> bytesOf(size_t count, auto value) {
  std::vector<std::byte> bytes(count);
  for (size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(value(i));
  return bytes;
}

TEST(PackedBlock, comesBackAsItWas) {
  for (const size_t voxel_bytes : {1U, 2U, 4U})
    for (const char* codec : {"lz4", "zstd", "blosclz", "zlib", "lz4hc"})
      for (const size_t count : {1024U, 4096U, 262144U}) {
        const auto voxels = bytesOf(count, [](size_t i) { return i / 97; });
        const auto packed = pack(voxels, voxel_bytes, {codec, 5});
        ASSERT_TRUE(packed) << codec << ' ' << count;
        EXPECT_LE(packed->byte_count, count * 7 / 8);
        std::vector<std::byte> out(count);
        unpack(*packed, out);
        EXPECT_TRUE(out == voxels) << codec << ' ' << count;
      }
}

TEST(PackedBlock, whatDoesNotShrinkIsNotPacked) {
  std::mt19937 random(1);
  const auto noise = bytesOf(100'000, [&](size_t) { return random(); });
  EXPECT_FALSE(pack(noise, 1));
  EXPECT_FALSE(pack(bytesOf(3, [](size_t i) { return i; }), 1));
}

TEST(PackedBlock, takesNoMoreMemoryThanItSays) {
  if (!MemoryPeak::works()) GTEST_SKIP() << "a sanitizer's allocator";
  for (const size_t voxel_bytes : {1U, 2U, 4U})
    for (const size_t voxels : {4096U, 65536U, 262144U, 274625U, 2097152U}) {
      const auto block = bytesOf(voxels * voxel_bytes, [](size_t i) { return i / 97; });
      const MemoryPeak peak;
      const auto packed = pack(block, voxel_bytes);
      ASSERT_TRUE(packed);
      // Seven eighths of the voxels, Blosc's header, and two of its blocks.
      const size_t bytes = block.size() - block.size() / 8 + 16 +
                           2 * std::min(block.size(), (size_t{128} << 10) * voxel_bytes);
      constexpr size_t kAllocatorsOwn = 16 << 10;
      EXPECT_LE(peak.bytes(), static_cast<int64_t>(bytes + kAllocatorsOwn))
          << voxels << " of " << voxel_bytes;
      EXPECT_GE(peak.bytes(), static_cast<int64_t>(block.size() * 7 / 8));  // it counts
    }
}

}  // namespace
}  // namespace sluice
