// ChunkTexels: the texels of a chunk in memory, shared between the level that filled them and a
// device that draws from them.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "src/base/vec.h"
#include "src/volume/device_voxel.h"

namespace sluice {

// In whole pages, x fastest. Immutable once filled; any thread may read.
struct ChunkTexels {
  Vec3i storage_vox;
  DeviceType type = DeviceType::kU8;
  size_t byte_count = 0;
  std::shared_ptr<std::byte[]> bytes;
  std::span<std::byte> span() const { return {bytes.get(), byte_count}; }
};
using ChunkTexelsPtr = std::shared_ptr<const ChunkTexels>;

}  // namespace sluice
