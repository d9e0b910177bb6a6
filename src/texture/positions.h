// What counts blocks, chunks and clusters of a plan, and chunks' names: a kind of number each, so
// that none is taken for another.
#pragma once

#include "src/base/strong_index.h"

namespace sluice {

using BlockPosition = StrongIndex<struct BlockPositionTag>;      // in TexturePlan::blocks
using ChunkPosition = StrongIndex<struct ChunkPositionTag>;      // in TexturePlan::chunks
using ClusterPosition = StrongIndex<struct ClusterPositionTag>;  // in TexturePlan::clusters

// What a chunk is called whatever plan asks for it (chunk_names.h), and those of a plan's chunks.
using ChunkName = StrongIndex<struct ChunkNameTag>;
using ChunkNameList = IndexedVector<ChunkPosition, ChunkName>;

}  // namespace sluice
