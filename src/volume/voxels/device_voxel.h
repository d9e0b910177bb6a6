// DeviceVoxel: the three scalar forms that levels 2 to 4 hold and draw, and the way into them.
//
// u8, u16 and f32 stay as they are stored; i8 and i16 are shifted to u8 and u16; u32, i32 and f64
// become f32: no type loses its range. In f32,
// - infinities, and values as far away, become -kLargest and kLargest, values like others: they are
//   interpolated with their neighbours, so that nearly all of the cells around them looks as the
//   transfer function's end does; they are no part of the value range;
// - NaN becomes kNotANumber, so far below all values that a sample with any part of it is below
// them
//   too; such a sample shows nothing.
// So interpolation never meets an undefined sum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "src/base/sources/volume_source.h"

namespace sluice {

enum class DeviceType { kU8, kU16, kF32 };

inline constexpr float kNotANumber = -3e38F;
inline constexpr float kLargest = 1e30F;

// 1, 2 or 4.
size_t bytesPerVoxel(DeviceType type);
// "u8", "u16", "f32".
const char* name(DeviceType type);

// The voxel type of levels 2 to 4 and how a value follows from it: value = device * scale + offset.
struct ValueMap {
  DeviceType type = DeviceType::kU8;
  double scale = 1, offset = 0;

  double valueOf(double device) const { return device * scale + offset; }
  double deviceOf(double value) const { return (value - offset) / scale; }
};
// The device type of a volume, and the values that its device voxels stand for.
ValueMap deviceMap(const VolumeLayout& layout);
// The device voxel of a stored value, exactly as `toDevice` makes it. Requires: `stored` is NaN or
// one of the type's values.
double deviceFromStored(VoxelType type, double stored);
// Whether `toDevice` copies voxels of this type as they are.
constexpr bool isStoredAsDevice(VoxelType type) {
  return type == VoxelType::kU8 || type == VoxelType::kU16;
}

// Converts packed voxels. Requires: out.size() == count * bytesPerVoxel(deviceMap(...).type).
void toDevice(VoxelType type, std::span<const std::byte> in, std::span<std::byte> out);

// Calls f with a value of the C++ type; returns what f returns.
template <class F>
decltype(auto) visitDeviceType(DeviceType type, F&& f) {
  switch (type) {
    case DeviceType::kU8:
      return f(uint8_t{});
    case DeviceType::kU16:
      return f(uint16_t{});
    case DeviceType::kF32:
      break;
  }
  return f(float{});
}

}  // namespace sluice
