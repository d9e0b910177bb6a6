#include "src/volume/ranges/byte_order_hint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/files/swap_bytes.h"
#include "io/open_volume.h"
#include "tests/support/memory_source.h"

namespace sluice::byte_order_hint_test {
namespace {

constexpr Vec3i kDims{60, 50, 40};

bool looksSwapped(VolumeSource& source) {
  WorkerPool pool(2);
  ProgressMeter quiet;
  return looksByteSwapped(
      buildSliceRanges(source, 0, blockLayout(source.layout().dims, 32, 0), {pool, quiet}),
      source.layout().type);
}

// Values as a detector or a simulation may give them, 0 to 1: smooth, with some noise and an empty
// outside.
double shapeAt(int64_t x, int64_t y, int64_t z) {
  const double r = std::hypot(static_cast<double>(x) - 30, static_cast<double>(y) - 25,
                              static_cast<double>(z) - 20);
  const auto noise = static_cast<double>((x * 7919 + y * 104729 + z * 1299709) % 101) / 101;
  if (r > 24) return 0;
  return std::clamp(
      0.5 + 0.3 * std::cos(r / 5) + 0.15 * std::sin(static_cast<double>(x) / 7) + 0.01 * noise, 0.0,
      1.0);
}

template <class T>
void expectToldApart(double scale, double offset) {
  std::vector<T> voxels;
  for (int64_t z = 0; z < kDims.z; ++z)
    for (int64_t y = 0; y < kDims.y; ++y)
      for (int64_t x = 0; x < kDims.x; ++x)
        voxels.push_back(static_cast<T>(shapeAt(x, y, z) * scale + offset));
  VolumeLayout layout;
  layout.dims = kDims;
  EXPECT_FALSE(looksSwapped(*memorySourceOf<T>(layout, voxels))) << scale;
  swapBytes(std::as_writable_bytes(std::span(voxels)), sizeof(T));
  EXPECT_TRUE(looksSwapped(*memorySourceOf<T>(layout, voxels))) << scale;
}

TEST(ByteOrderHint, tellsTheTwoOrdersApart) {
  expectToldApart<uint16_t>(4095, 0);
  expectToldApart<uint16_t>(65535, 0);
  expectToldApart<int16_t>(3000, -1024);
  expectToldApart<uint32_t>(50000, 0);
  expectToldApart<int32_t>(4000, -2000);
  expectToldApart<float>(1, 0);
  expectToldApart<float>(2000, -1000);
}

TEST(ByteOrderHint, whatIsUnusualButRightIsLetPass) {
  const auto passes = [](auto value) {
    return !looksSwapped(*makeMemorySource<uint16_t>(kDims, value));
  };
  const auto of = [](int64_t x, int64_t y, int64_t z) {
    return static_cast<uint16_t>(shapeAt(x, y, z) * 255);
  };
  // 8 bits in the upper half, or in both.
  EXPECT_TRUE(passes([&](auto x, auto y, auto z) { return of(x, y, z) * 256; }));
  EXPECT_TRUE(passes([&](auto x, auto y, auto z) { return of(x, y, z) * 257; }));
  EXPECT_TRUE(passes([&](auto x, auto y, auto z) { return of(x, y, z); }));
  EXPECT_TRUE(passes([](auto x, auto y, auto z) { return (x + y + z) % 3; }));
  EXPECT_TRUE(passes([](auto, auto, auto) { return 7; }));
  // A fill value far off.
  EXPECT_FALSE(looksSwapped(*makeMemorySource<float>(
      kDims, [](auto x, auto y, auto z) { return x < 5 ? 9.9e36F : shapeAt(x, y, z); })));
  EXPECT_FALSE(looksSwapped(
      *makeMemorySource<uint8_t>(kDims, [&](auto x, auto y, auto z) { return of(x, y, z); })));
}

TEST(ByteOrderHint, realVolumesOfSixteenBits) {
  const std::string tooth = SLUICE_DATA_DIR "/tooth/tooth.nhdr";
  const std::string walnut = SLUICE_DATA_DIR "/walnut_128x96x114_uint16.raw";
  if (!std::filesystem::exists(tooth)) GTEST_SKIP() << tooth << " is missing";
  EXPECT_FALSE(looksSwapped(*openVolume(tooth)));
  EXPECT_FALSE(looksSwapped(*openVolume(walnut)));
  EXPECT_TRUE(looksSwapped(*openVolume(walnut, {.byte_order = std::endian::big})));
}

}  // namespace
}  // namespace sluice::byte_order_hint_test
