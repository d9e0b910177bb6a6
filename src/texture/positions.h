// Index types for the blocks, chunks and clusters of a plan and for chunk names. Each is a type of
// its own, so that none is taken for another.
#pragma once

#include "src/base/values/strong_index.h"

namespace sluice {

using BlockPosition = StrongIndex<struct BlockPositionTag>;      // in TexturePlan::blocks
using ChunkPosition = StrongIndex<struct ChunkPositionTag>;      // in TexturePlan::chunks
using ClusterPosition = StrongIndex<struct ClusterPositionTag>;  // in TexturePlan::clusters

// The name of a chunk, the same in every plan that asks for it (chunk_names.h), and the names of a
// plan's chunks.
using ChunkName = StrongIndex<struct ChunkNameTag>;
using ChunkNameList = IndexedVector<ChunkPosition, ChunkName>;

}  // namespace sluice
