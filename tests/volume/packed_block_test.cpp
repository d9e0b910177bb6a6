#include "src/volume/packed_block.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

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

}  // namespace
}  // namespace sluice
