// fillChunk: copies the voxels of a chunk's texture blocks from their volume blocks, turned so that
// each trimming axis is texture z (Tong 1999, section 3.2.2).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "src/texture/texture_plan.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

// Copies the voxels of `block` (whose volume block is `from`) to their place in a chunk whose
// storage is `storage_vox` texels, x fastest, and clears the rest of `room`: of the texels that are
// this block's to write, from block.at on. Voxels outside the volume repeat the boundary: the
// clamped neighbours that central differences want; padding is never sampled but with weight 0,
// where it must be a number. The spreads of a volume block that has some go beside the means. All
// voxel planes have the values of those of `planes`, as far as the volume block has these.
// Requires: out.size() == volume(storage_vox) * numbers a voxel * bytes of a number; room within
// the storage.
void copyTextureBlock(const TextureBlock& block, const VolumeBlock& from, Vec3i storage_vox,
                      Vec3i room, std::span<std::byte> out, const VoxelPlanes& planes = {});

// The texels of a chunk divided among its blocks: the part that each fills from its place on, in
// the order of chunk.blocks. Together they are the whole storage, once.
std::vector<Vec3i> roomsOf(const TexturePlan& plan, const Chunk& chunk, Vec3i storage_vox);

}  // namespace sluice
