#include "src/base/values/voxel_type.h"

#include <array>

namespace sluice {
namespace {

struct Names {
  VoxelType type;
  std::array<std::string_view, 4> names;  // the first is the one we print
};
constexpr std::array<Names, 8> kNames = {{
    {VoxelType::kU8, {"u8", "uint8", "uchar", "uint8_t"}},
    {VoxelType::kI8, {"i8", "int8", "char", "int8_t"}},
    {VoxelType::kU16, {"u16", "uint16", "ushort", "uint16_t"}},
    {VoxelType::kI16, {"i16", "int16", "short", "int16_t"}},
    {VoxelType::kU32, {"u32", "uint32", "uint", "uint32_t"}},
    {VoxelType::kI32, {"i32", "int32", "int", "int32_t"}},
    {VoxelType::kF32, {"f32", "float32", "float", "single"}},
    {VoxelType::kF64, {"f64", "float64", "double", "double"}},
}};

}  // namespace

size_t bytesPerVoxel(VoxelType type) {
  return visitVoxelType(type, [](auto tag) { return sizeof(tag); });
}

std::string_view name(VoxelType type) {
  return kNames[static_cast<size_t>(type)].names[0];
}

std::optional<VoxelType> parseVoxelType(std::string_view text) {
  for (const Names& entry : kNames)
    for (std::string_view candidate : entry.names)
      if (candidate == text) return entry.type;
  return std::nullopt;
}

}  // namespace sluice
