// A texture buffer over a volume of blocks of one size, and a check of each texel that it gives.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "src/texture/chunk_names.h"
#include "src/texture/texture_buffer.h"
#include "tests/support/counting_source.h"
#include "tests/support/random_volume.h"
#include "tests/texture/random_plan.h"

namespace sluice {

// Each chunk of a plan, in order.
std::vector<ChunkPosition> allChunks(const TexturePlan& plan);
// By number.
std::vector<ChunkPosition> chunksOf(const std::vector<int64_t>& numbers);

// Each texel of each texture block against the voxel that it stands for, found the long way; all
// others are 0.
void expectTexels(const TexturePlan& plan, ChunkPosition position, const ChunkTexels& texels,
                  const MemorySource& source);
// The same of a plan of several levels.
void expectTexels(const TexturePlan& plan, ChunkPosition position, const ChunkTexels& texels,
                  std::span<const MemorySource* const> levels);

// 4 x 3 x 2 whole blocks of 8^3 bytes, a chunk each.
inline constexpr Vec3i kDims{4 * 7 + 1, 3 * 7 + 1, 2 * 7 + 1};
inline constexpr uint64_t kChunkBytes = 512;

class TextureBufferTest : public testing::Test {
 protected:
  // Buffers with room for `chunks` and, at the level below, `blocks`; `source` must outlive them.
  std::unique_ptr<TextureBuffer> bufferOf(VolumeSource& source, uint64_t chunks,
                                          uint64_t blocks = 24) {
    blocks_ = std::make_unique<VolumeBuffer>(source, layout_, blocks * kChunkBytes);
    return std::make_unique<TextureBuffer>(*blocks_, pool_, chunks * kChunkBytes);
  }
  std::vector<ChunkTexelsPtr> acquire(TextureBuffer& buffer, const std::vector<int64_t>& chunks) {
    return buffer.acquire(plan_, names_, chunksOf(chunks));
  }

  const BlockLayout layout_ = blockLayout(kDims, 8, 0);
  const PageGeometry page_{{8, 8, 1}, 1, 32};
  const std::unique_ptr<MemorySource> memory_ = makeWhiteNoise(kDims, VoxelType::kU8, 1);
  CountingSource counted_{*memory_};
  const TexturePlan plan_ =
      planTextures(layout_, allBlack(layout_), page_, planOptions(layout_, Algorithm::kTrimmed));
  ChunkNames chunk_names_;
  const ChunkNameList names_ = chunk_names_.namesOf(plan_);
  WorkerPool pool_{2};
  std::unique_ptr<VolumeBuffer> blocks_;
};

}  // namespace sluice
