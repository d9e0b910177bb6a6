// MemorySource: a VolumeSource over voxels in memory, so that a test knows every one of them.
//
//   auto source = makeMemorySource<uint8_t>({4, 4, 4}, [](auto x, auto y, auto z) { return x; });
//
// Owns its voxels. Constant after construction but for the byte count; any thread may read.
#pragma once

#include <atomic>
#include <concepts>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

// The VoxelType of a C++ type.
template <class T>
constexpr VoxelType voxelTypeOf() {
  if constexpr (std::is_same_v<T, uint8_t>) return VoxelType::kU8;
  if constexpr (std::is_same_v<T, int8_t>) return VoxelType::kI8;
  if constexpr (std::is_same_v<T, uint16_t>) return VoxelType::kU16;
  if constexpr (std::is_same_v<T, int16_t>) return VoxelType::kI16;
  if constexpr (std::is_same_v<T, uint32_t>) return VoxelType::kU32;
  if constexpr (std::is_same_v<T, int32_t>) return VoxelType::kI32;
  if constexpr (std::is_same_v<T, float>) return VoxelType::kF32;
  return VoxelType::kF64;
}

class MemorySource : public VolumeSource {
 public:
  // `voxels`: x fastest, time step after time step, dims * time_steps of layout.type.
  MemorySource(VolumeLayout layout, std::vector<std::byte> voxels);

  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  // Differs between any two sources of a process.
  std::string identity() const override { return identity_; }
  // Bytes handed out: memory stands for the disk here.
  uint64_t storedBytesRead() const override { return read_bytes_; }

  // All voxels of all time steps, as given.
  std::span<const std::byte> bytes() const { return voxels_; }

 private:
  const VolumeLayout layout_;
  const std::vector<std::byte> voxels_;
  const std::string identity_;
  std::atomic<uint64_t> read_bytes_{0};
};

// Voxels of T in the order of MemorySource; layout.type is set from T.
template <class T>
std::unique_ptr<MemorySource> memorySourceOf(VolumeLayout layout, const std::vector<T>& voxels) {
  layout.type = voxelTypeOf<T>();
  std::vector<std::byte> bytes(voxels.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), voxels.data(), bytes.size());
  return std::make_unique<MemorySource>(std::move(layout), std::move(bytes));
}

// Voxels from value(x, y, z) or value(x, y, z, t), cast to T.
template <class T, std::same_as<VolumeLayout> Layout, class F>
std::unique_ptr<MemorySource> makeMemorySource(Layout layout, F&& value) {
  std::vector<T> voxels;
  voxels.reserve(static_cast<size_t>(volume(layout.dims) * layout.time_steps));
  for (int64_t t = 0; t < layout.time_steps; ++t)
    for (int64_t z = 0; z < layout.dims.z; ++z)
      for (int64_t y = 0; y < layout.dims.y; ++y)
        for (int64_t x = 0; x < layout.dims.x; ++x) {
          if constexpr (std::is_invocable_v<F, int64_t, int64_t, int64_t, int64_t>)
            voxels.push_back(static_cast<T>(value(x, y, z, t)));
          else
            voxels.push_back(static_cast<T>(value(x, y, z)));
        }
  return memorySourceOf<T>(std::move(layout), voxels);
}

// The same with a layout of unit spacing.
template <class T, class F>
std::unique_ptr<MemorySource> makeMemorySource(Vec3i dims, F&& value) {
  VolumeLayout layout;
  layout.dims = dims;
  return makeMemorySource<T>(std::move(layout), std::forward<F>(value));
}

}  // namespace sluice
