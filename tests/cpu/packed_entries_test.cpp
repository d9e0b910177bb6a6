#include "src/cpu/kernels/packed_entries.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

// Unpacks like the kernels.
double unpacked(int64_t entry, size_t channel, const PackedEntries& packed) {
  const auto bits = static_cast<uint32_t>(static_cast<uint64_t>(entry) >> (16 * channel) & 0xFFFF);
  const float unit = channel == 3 ? packed.opacity_unit : packed.color_unit;
  return std::bit_cast<float>(bits << kPackedShift) * unit;
}

TEST(PackedEntries, numbersComeBackToWhatIsPromised) {
  for (const float sign : {1.0F, -1.0F}) {
    std::vector<float> rgba;
    for (int i = 0; i < 400; ++i) {
      const auto v = static_cast<float>(std::pow(0.93, i));
      rgba.insert(rgba.end(), {v, 0.7F * v, 0, sign * 0.2F * v});
    }
    const PackedEntries packed = packedEntries(rgba, 32);
    ASSERT_EQ(packed.entries.size(), 400U);
    for (size_t i = 0; i < rgba.size(); ++i) {
      const double most = i % 4 == 3 ? 0.2 : 1, expected = static_cast<double>(rgba[i]);
      EXPECT_NEAR(unpacked(packed.entries[i / 4], i % 4, packed), expected,
                  std::max(1.23e-4 * std::abs(expected), 1.6e-8 * most))
          << i;
    }
  }
}

TEST(PackedEntries, nothingIsExactlyNothingAndTheGreatestIsExact) {
  const std::vector<float> rgba = {0, 0, 0, 0, 1, 1, 0.5F, 1};
  const PackedEntries packed = packedEntries(rgba, 32);
  for (size_t i = 0; i < rgba.size(); ++i)
    EXPECT_EQ(unpacked(packed.entries[i / 4], i % 4, packed), rgba[i]) << i;
  const PackedEntries none = packedEntries(std::vector<float>(8), 32);
  EXPECT_EQ(none.entries, (std::vector<int64_t>{0, 0}));
}

TEST(PackedEntries, logarithmsEndWhereAllIsOpaque) {
  const std::vector<float> rgba = {1, 1, 1, -1e4F, 1, 1, 1, -0.25F};
  const PackedEntries packed = packedEntries(rgba, 32);
  EXPECT_EQ(unpacked(packed.entries[0], 3, packed), -32);
  EXPECT_NEAR(unpacked(packed.entries[1], 3, packed), -0.25, 2e-5);
}

}  // namespace
}  // namespace sluice
