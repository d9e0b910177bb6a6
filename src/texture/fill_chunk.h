// fillChunk: copies the voxels of a chunk's texture blocks from their volume blocks, turned so that
// each trimming axis is texture z (Tong 1999, section 3.2.2).
#pragma once

#include <cstddef>
#include <span>

#include "src/texture/texture_plan.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

// Copies the voxels of `block` (whose volume block is `from`) to their place in a chunk whose
// storage is `storage_vox` texels, x fastest. Voxels outside the volume repeat the boundary: the
// clamped neighbours that central differences want; padding is never sampled.
// Requires: out.size() == volume(storage_vox) * bytes a voxel.
void copyTextureBlock(const TextureBlock& block, const VolumeBlock& from, Vec3i storage_vox,
                      std::span<std::byte> out);

}  // namespace sluice
