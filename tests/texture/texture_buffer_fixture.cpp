#include "tests/texture/texture_buffer_fixture.h"

#include <algorithm>
#include <cstring>

namespace sluice {

std::vector<ChunkPosition> allChunks(const TexturePlan& plan) {
  std::vector<ChunkPosition> chunks;
  for (const ChunkPosition chunk : plan.chunks.indices()) chunks.push_back(chunk);
  return chunks;
}

std::vector<ChunkPosition> chunksOf(const std::vector<int64_t>& numbers) {
  std::vector<ChunkPosition> chunks;
  for (const int64_t number : numbers) chunks.emplace_back(number);
  return chunks;
}

void expectTexels(const TexturePlan& plan, ChunkPosition position, const ChunkTexels& texels,
                  const MemorySource& source) {
  const MemorySource* const one = &source;
  expectTexels(plan, position, texels, std::span(&one, 1));
}

void expectTexels(const TexturePlan& plan, ChunkPosition position, const ChunkTexels& texels,
                  std::span<const MemorySource* const> levels) {
  const Chunk& chunk = plan.chunks[position];
  const int32_t level = plan.blocks[chunk.blocks.front()].name.level;
  const MemorySource& source = *levels[static_cast<size_t>(level)];
  const size_t size = bytesPerVoxel(deviceMap(source.layout()).type);
  const size_t stored_size = bytesPerVoxel(source.layout().type);
  const Vec3i dims = source.layout().dims;
  ASSERT_EQ(texels.storage_vox, plan.page.pageGridOf(chunk.size_vox) * plan.page.size_vox);
  ASSERT_EQ(texels.byte_count, static_cast<size_t>(volume(texels.storage_vox)) * size);
  std::vector<std::byte> expected(size);
  std::vector<bool> covered(static_cast<size_t>(volume(texels.storage_vox)));
  for (const BlockPosition b : chunk.blocks) {
    const TextureBlock& block = plan.blocks[b];
    const Vec3i count = block.texels();
    for (int64_t z = 0; z < count.z; ++z)
      for (int64_t y = 0; y < count.y; ++y)
        for (int64_t x = 0; x < count.x; ++x) {
          const int axis = block.trimming_axis;
          Vec3i voxel;  // texture z is the trimming axis, x and y the next two in turn
          voxel[axis] = block.voxels.lo[axis] + z;
          voxel[(axis + 1) % 3] = block.voxels.lo[(axis + 1) % 3] + x;
          voxel[(axis + 2) % 3] = block.voxels.lo[(axis + 2) % 3] + y;
          voxel = max(Vec3i{0, 0, 0}, min(voxel, dims - Vec3i{1, 1, 1}));  // the border repeats
          const auto at = static_cast<size_t>((voxel.z * dims.y + voxel.y) * dims.x + voxel.x);
          toDevice(source.layout().type, source.bytes().subspan(at * stored_size, stored_size),
                   expected);
          const Vec3i t = block.at + Vec3i{x, y, z};
          const auto texel =
              static_cast<size_t>((t.z * texels.storage_vox.y + t.y) * texels.storage_vox.x + t.x);
          ASSERT_EQ(std::memcmp(texels.bytes.get() + texel * size, expected.data(), size), 0)
              << "block " << block.name.block << " axis " << axis << " texel " << t.x << ' ' << t.y
              << ' ' << t.z;
          covered[texel] = true;
        }
  }
  std::ranges::fill(expected, std::byte{0});
  for (size_t texel = 0; texel < covered.size(); ++texel) {
    if (covered[texel]) continue;
    ASSERT_EQ(std::memcmp(texels.bytes.get() + texel * size, expected.data(), size), 0)
        << "of no block: " << texel;
  }
}

}  // namespace sluice
