#include "src/volume/voxels/device_voxel.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "src/base/error.h"

namespace sluice {
namespace {

// The type is the stored one; the shift makes signed integers unsigned.
template <class Stored>
auto convert(Stored v) {
  if constexpr (std::is_same_v<Stored, uint8_t> || std::is_same_v<Stored, uint16_t>) {
    return v;
  } else if constexpr (std::is_same_v<Stored, int8_t>) {
    return static_cast<uint8_t>(v + 128);
  } else if constexpr (std::is_same_v<Stored, int16_t>) {
    return static_cast<uint16_t>(v + 32768);
  } else if constexpr (std::is_integral_v<Stored>) {
    // Rounded to 24 bits. A neighbouring integer may get the same float.
    return static_cast<float>(v);
  } else {
    if (std::isnan(v)) return kNotANumber;
    // Infinities are clamped, too, so that interpolation has no undefined sums.
    return static_cast<float>(std::clamp<double>(v, -kLargest, kLargest));
  }
}

template <class Stored>
void convertAll(std::span<const std::byte> in, std::span<std::byte> out) {
  using Device = decltype(convert(Stored{}));
  if constexpr (std::is_same_v<Stored, Device> && std::is_integral_v<Stored>) {
    std::copy(in.begin(), in.end(), out.begin());
  } else {
    // The buffers come from allocators of bytes and are aligned for any scalar.
    const auto* from = reinterpret_cast<const Stored*>(in.data());
    auto* to = reinterpret_cast<Device*>(out.data());
    const size_t count = in.size() / sizeof(Stored);
    for (size_t i = 0; i < count; ++i) to[i] = convert(from[i]);
  }
}

int64_t shiftOf(VoxelType type) {
  if (type == VoxelType::kI8) return 128;
  if (type == VoxelType::kI16) return 32768;
  return 0;
}

}  // namespace

size_t bytesPerVoxel(DeviceType type) {
  return visitDeviceType(type, [](auto tag) { return sizeof(tag); });
}

const char* name(DeviceType type) {
  switch (type) {
    case DeviceType::kU8:
      return "u8";
    case DeviceType::kU16:
      return "u16";
    case DeviceType::kF32:
      break;
  }
  return "f32";
}

ValueMap deviceMap(const VolumeLayout& layout) {
  const DeviceType type = visitVoxelType(layout.type, [](auto tag) {
    using Device = decltype(convert(tag));
    if (std::is_same_v<Device, uint8_t>) return DeviceType::kU8;
    if (std::is_same_v<Device, uint16_t>) return DeviceType::kU16;
    return DeviceType::kF32;
  });
  // The map absorbs the shift, so that values stay the file's.
  const double shift = static_cast<double>(shiftOf(layout.type));
  return {type, layout.value_scale, layout.value_offset - shift * layout.value_scale};
}

double deviceFromStored(VoxelType type, double stored) {
  return visitVoxelType(type, [stored](auto tag) {
    using Stored = decltype(tag);
    // An integer has no NaN: whoever asks for one means the float that it becomes.
    if (std::is_integral_v<Stored> && std::isnan(stored)) return static_cast<double>(kNotANumber);
    return static_cast<double>(convert(static_cast<Stored>(stored)));
  });
}

void toDevice(VoxelType type, std::span<const std::byte> in, std::span<std::byte> out) {
  visitVoxelType(type, [&](auto tag) {
    SLUICE_CHECK_EQ(in.size() / sizeof(tag) * sizeof(convert(tag)), out.size());
    convertAll<decltype(tag)>(in, out);
  });
}

}  // namespace sluice
