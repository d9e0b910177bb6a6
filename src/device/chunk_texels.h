// ChunkTexels: the texels of a chunk in memory, shared between the level that filled them and a
// device that draws from them.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "src/base/values/vec.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// The texels of a chunk in whole pages, x fastest. A texel is one number, or with `has_spread` two,
// one after the other: the mean of the values that it stands for, and their spread in the same unit
// (expected_look.h); or the most frequent label among them, and the share of the others, of which
// wholeShare() stands for all. Immutable once filled; any thread may read.
struct ChunkTexels {
  Vec3i storage_vox;
  Vec3i size_vox;  // of its blocks, from the first texel on: no sample needs the others
  DeviceType type = DeviceType::kU8;
  bool has_spread = false;
  size_t byte_count = 0;
  std::shared_ptr<std::byte[]> bytes;
  size_t texelBytes() const { return bytesPerVoxel(type) * (has_spread ? 2 : 1); }
  std::span<std::byte> span() const { return {bytes.get(), byte_count}; }
};
// The second number of a texel of labels if all values below it were others.
constexpr double wholeShare(DeviceType type) {
  switch (type) {
    case DeviceType::kU8:
      return 0xFF;
    case DeviceType::kU16:
      return 0xFFFF;
    case DeviceType::kF32:
      break;
  }
  return 1;
}
using ChunkTexelsPtr = std::shared_ptr<const ChunkTexels>;

}  // namespace sluice
