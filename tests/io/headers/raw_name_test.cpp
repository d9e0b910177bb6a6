#include "io/headers/raw/raw_name.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

TEST(RawNameTest, takesDimensionsAndTypeFromTheCollectionsNames) {
  const RawName name = parseRawName("head_256x255x225_uint8.raw");
  EXPECT_TRUE(name.dims == (Vec3i{256, 255, 225}));
  EXPECT_EQ(name.type, VoxelType::kU8);
  EXPECT_FALSE(name.time_steps);
  EXPECT_FALSE(name.byte_order);
}

TEST(RawNameTest, knowsEveryType) {
  const std::pair<const char*, VoxelType> cases[] = {
      {"a_2x3x4_uint8.raw", VoxelType::kU8},    {"a_2x3x4_int8.raw", VoxelType::kI8},
      {"a_2x3x4_uint16.raw", VoxelType::kU16},  {"a_2x3x4_INT16.RAW", VoxelType::kI16},
      {"a_2x3x4_uint32.raw", VoxelType::kU32},  {"a_2x3x4_i32.raw", VoxelType::kI32},
      {"a_2x3x4_float32.raw", VoxelType::kF32}, {"a_2x3x4_float64.raw", VoxelType::kF64},
      {"a-2x3x4-double.raw", VoxelType::kF64},  {"a.2x3x4.uchar.raw", VoxelType::kU8},
      {"uint16_2x3x4.raw.gz", VoxelType::kU16}};
  for (const auto& [text, type] : cases) {
    EXPECT_EQ(parseRawName(text).type, type) << text;
    EXPECT_TRUE(parseRawName(text).dims == (Vec3i{2, 3, 4})) << text;
  }
}

TEST(RawNameTest, aFourthNumberIsTime) {
  EXPECT_EQ(parseRawName("flow_64x64x32x10_float32.raw").time_steps, 10);
}

TEST(RawNameTest, takesTheByteOrderAfterTheDimensions) {
  EXPECT_EQ(parseRawName("a_2x3x4_uint16_be.raw").byte_order, std::endian::big);
  EXPECT_EQ(parseRawName("a_2x3x4_uint16_le.raw").byte_order, std::endian::little);
  EXPECT_FALSE(parseRawName("be_2x3x4_uint16.raw").byte_order);
}

TEST(RawNameTest, leavesOpenWhatTheNameDoesNotSay) {
  for (const char* text : {"head.raw", "", "x", "512x512.raw", "2x3x4x5x6.raw", "0x3x4.raw",
                           "2x3xx4.raw", "99999999999999999999x1x1.raw", "_x_x_"})
    EXPECT_FALSE(parseRawName(text).dims) << text;
  EXPECT_FALSE(parseRawName("double_shell_2x3x4.raw").type);
}

TEST(RawNameTest, findsTheFirstThingInANameThatIsNotTrue) {
  const auto found = [](const char* file) {
    return falseInName(file, {8, 8, 8}, VoxelType::kU16, std::endian::little);
  };
  EXPECT_EQ(found("z_16x8x8_uint8.raw"), "16 x 8 x 8 voxels");
  EXPECT_EQ(found("z_8x8x8x4_uint16.raw"), "4 time steps");
  EXPECT_EQ(found("z_8x8x8_uint8.raw"), "u8");
  EXPECT_EQ(found("z_8x8x8_uint16_be.raw"), "big-endian");
  for (const char* file : {"z.raw", "z_8x8x8.raw", "z_8x8x8_uint16_le.raw", "uint16_t0042.raw"})
    EXPECT_EQ(found(file), "") << file;
  EXPECT_EQ(falseInName("z_8x8x8_uint8_be.raw", {8, 8, 8}, VoxelType::kU8, std::endian::little),
            "");
}

}  // namespace
}  // namespace sluice
