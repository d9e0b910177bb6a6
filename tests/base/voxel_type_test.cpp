#include "src/base/values/voxel_type.h"

#include <gtest/gtest.h>

#include <array>
#include <type_traits>

namespace sluice {
namespace {

constexpr std::array kTypes = {VoxelType::kU8,  VoxelType::kI8,  VoxelType::kU16, VoxelType::kI16,
                               VoxelType::kU32, VoxelType::kI32, VoxelType::kF32, VoxelType::kF64};

TEST(VoxelType, namesSayKindAndBits) {
  for (const VoxelType type : kTypes) {
    const std::string_view text = name(type);
    EXPECT_EQ(std::stoul(std::string(text.substr(1))), 8 * bytesPerVoxel(type)) << text;
    visitVoxelType(type, [&](auto tag) {
      using T = decltype(tag);
      EXPECT_EQ(sizeof(T), bytesPerVoxel(type));
      EXPECT_EQ(text[0], std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u');
    });
  }
}

TEST(VoxelType, parseTakesEveryNameBack) {
  for (const VoxelType type : kTypes) EXPECT_EQ(parseVoxelType(name(type)), type);
}

TEST(VoxelType, parseTakesTheLongNames) {
  EXPECT_EQ(parseVoxelType("uint8"), VoxelType::kU8);
  EXPECT_EQ(parseVoxelType("int8"), VoxelType::kI8);
  EXPECT_EQ(parseVoxelType("uint16"), VoxelType::kU16);
  EXPECT_EQ(parseVoxelType("short"), VoxelType::kI16);
  EXPECT_EQ(parseVoxelType("uint32"), VoxelType::kU32);
  EXPECT_EQ(parseVoxelType("int32"), VoxelType::kI32);
  EXPECT_EQ(parseVoxelType("float"), VoxelType::kF32);
  EXPECT_EQ(parseVoxelType("double"), VoxelType::kF64);
}

TEST(VoxelType, parseRefusesOthers) {
  for (const char* text : {"", "u", "u64", "U8", "u8 ", "complex"})
    EXPECT_EQ(parseVoxelType(text), std::nullopt) << text;
}

}  // namespace
}  // namespace sluice
