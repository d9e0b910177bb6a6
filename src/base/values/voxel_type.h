// VoxelType: the scalar types a file may store, and the way from a run-time type to a C++ one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace sluice {

enum class VoxelType { kU8, kI8, kU16, kI16, kU32, kI32, kF32, kF64 };

// 1, 2, 4 or 8.
size_t bytesPerVoxel(VoxelType type);
// "u8", "i8", ... "f64": the names that --type takes.
std::string_view name(VoxelType type);
// Also understands the long names "uint8", "float", "double", ...; nullopt when unknown.
std::optional<VoxelType> parseVoxelType(std::string_view text);

// Calls f with a value of the C++ type, so that `decltype(tag)` names it; returns what f returns.
template <class F>
decltype(auto) visitVoxelType(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::kU8:
      return f(uint8_t{});
    case VoxelType::kI8:
      return f(int8_t{});
    case VoxelType::kU16:
      return f(uint16_t{});
    case VoxelType::kI16:
      return f(int16_t{});
    case VoxelType::kU32:
      return f(uint32_t{});
    case VoxelType::kI32:
      return f(int32_t{});
    case VoxelType::kF32:
      return f(float{});
    case VoxelType::kF64:
      break;
  }
  return f(double{});
}

}  // namespace sluice
