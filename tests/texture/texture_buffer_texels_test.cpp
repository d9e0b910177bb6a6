// The texels of a chunk: each is the voxel that it stands for, and texels that no block fills are
// 0.
#include <gtest/gtest.h>

#include <malloc.h>

#include <array>
#include <cstring>
#include <memory>
#include <random>
#include <set>
#include <vector>

#include "src/texture/fill_chunk.h"
#include "src/texture/texture_buffer.h"
#include "tests/texture/texture_buffer_fixture.h"

namespace sluice {
namespace {

// New memory holds junk, as an evicted chunk's does.
struct JunkInNewMemory {
  JunkInNewMemory() { mallopt(M_PERTURB, 0x5a); }
  ~JunkInNewMemory() { mallopt(M_PERTURB, 0); }
};

TEST(TextureBuffer, eachTexelIsTheVoxelItStandsFor) {
  const JunkInNewMemory junk;
  std::mt19937_64 random(1);
  std::array<int, 3> axes_seen{};
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32, VoxelType::kF64})
    for (const int ghost : {0, 1})
      for (const Algorithm algorithm : {Algorithm::kConventional, Algorithm::kClipped,
                                        Algorithm::kTrimmed, Algorithm::kMerged}) {
        const Vec3i dims{29, 20, 24};
        const auto source = makeWhiteNoise(dims, type, 3);
        const BlockLayout layout = blockLayout(dims, 8, ghost);
        const auto device_size =
            static_cast<int64_t>(bytesPerVoxel(deviceMap(source->layout()).type));
        // Blocks that fill their pages along x and y, and such that do not.
        const PageGeometry page{ghost == 0 ? Vec3i{4, 8, 2} : Vec3i{32, 16, 2}, device_size, 64};
        const TexturePlan plan = planTextures(layout, randomVisibleBlocks(layout, 0.5, random),
                                              page, planOptions(layout, algorithm));
        for (const TextureBlock& block : plan.blocks)
          ++axes_seen[static_cast<size_t>(block.trimming_axis)];
        WorkerPool pool(3);
        VolumeBuffer blocks(*source, layout, 1 << 20);
        TextureBuffer buffer(blocks, pool, 16 << 20);
        ChunkNames names;
        const std::vector<ChunkPosition> chunks = allChunks(plan);
        const auto texels = buffer.acquire(plan, names.namesOf(plan), chunks);
        ASSERT_EQ(texels.size(), chunks.size());
        for (size_t i = 0; i < chunks.size(); ++i) {
          expectTexels(plan, chunks[i], *texels[i], *source);
          if (HasFatalFailure()) FAIL() << name(type) << ' ' << name(algorithm) << ' ' << ghost;
        }
      }
  for (const int count : axes_seen) EXPECT_GT(count, 50);
}

// Their voxels are copied in squares if the trimming axis is not z.
TEST(TextureBuffer, eachTexelOfBlocksOf32IsTheVoxelItStandsFor) {
  const JunkInNewMemory junk;
  std::mt19937_64 random(2);
  std::array<int, 3> axes_seen{};
  const Vec3i dims{107, 75, 90};
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kF32})
    for (const int ghost : {0, 1}) {
      const auto source = makeWhiteNoise(dims, type, 3);
      const BlockLayout layout = blockLayout(dims, 32, ghost);
      const auto device_size =
          static_cast<int64_t>(bytesPerVoxel(deviceMap(source->layout()).type));
      const PageGeometry page{{40, 8, 2}, device_size, 512};
      const TexturePlan plan = planTextures(layout, randomVisibleBlocks(layout, 0.8, random), page,
                                            planOptions(layout, Algorithm::kMerged));
      for (const TextureBlock& block : plan.blocks)
        ++axes_seen[static_cast<size_t>(block.trimming_axis)];
      WorkerPool pool(2);
      VolumeBuffer blocks(*source, layout, 8 << 20);
      TextureBuffer buffer(blocks, pool, 64 << 20);
      ChunkNames names;
      const std::vector<ChunkPosition> chunks = allChunks(plan);
      const auto texels = buffer.acquire(plan, names.namesOf(plan), chunks);
      for (size_t i = 0; i < chunks.size(); ++i) {
        expectTexels(plan, chunks[i], *texels[i], *source);
        if (HasFatalFailure()) FAIL() << name(type) << ' ' << ghost;
      }
    }
  for (const int count : axes_seen) EXPECT_GT(count, 10);
}

TEST(TextureBuffer, smallVolumesArePaddedByTheirBorder) {
  // A single block of 8 over a volume of 3 x 2 x 5 voxels.
  const auto source = makeWhiteNoise({3, 2, 5}, VoxelType::kU16, 3);
  for (const int ghost : {0, 1}) {
    const BlockLayout layout = blockLayout({3, 2, 5}, 8, ghost);
    const PageGeometry page{{8, 8, 8}, 2, 16};
    for (const Algorithm algorithm : {Algorithm::kConventional, Algorithm::kTrimmed}) {
      const TexturePlan plan =
          planTextures(layout, allBlack(layout), page, planOptions(layout, algorithm));
      WorkerPool pool(1);
      VolumeBuffer blocks(*source, layout, 1 << 20);
      TextureBuffer buffer(blocks, pool, 1 << 20);
      ChunkNames names;
      const auto texels = buffer.acquire(plan, names.namesOf(plan), allChunks(plan));
      expectTexels(plan, ChunkPosition(int64_t{0}), *texels.at(0), *source);
    }
  }
}

TEST(TextureBufferDeathTest, storageMustBeOfTheSizeItSays) {
  VolumeBlock from;
  from.voxels = {{0, 0, 0}, {2, 2, 2}};
  from.bytes = std::make_unique<std::byte[]>(8);
  TextureBlock block;
  block.voxels = from.voxels;
  std::vector<std::byte> out(7);
  EXPECT_DEATH(copyTextureBlock(block, from, {2, 2, 2}, {2, 2, 2}, out), "check failed");
}

// The first or the second number of each texel, as a chunk of one number a texel.
ChunkTexels numberOf(const ChunkTexels& texels, size_t which) {
  const size_t size = bytesPerVoxel(texels.type);
  ChunkTexels one = texels;
  one.has_spread = false;
  one.byte_count = texels.byte_count / 2;
  one.bytes = std::make_shared<std::byte[]>(one.byte_count);
  for (size_t i = 0; i < one.byte_count; i += size)
    std::memcpy(one.bytes.get() + i, texels.bytes.get() + 2 * i + which * size, size);
  return one;
}

// Each chunk has the voxels of its own level, whatever level the blocks beside it in the buffer are
// of, and their spreads if the level has some.
class TextureBufferCutTest : public testing::TestWithParam<int> {};

TEST_P(TextureBufferCutTest, chunksOfACutHoldTheVoxelsOfTheirLevels) {
  const int numbers = GetParam();
  const PyramidLayout pyramid = threeLevels({50, 36, 43}, 8, 1, numbers);
  std::vector<std::unique_ptr<MemorySource>> sources;
  std::vector<const MemorySource*> levels, spreads;
  std::vector<VolumeBuffer::Level> read;
  const auto noise = [&](Vec3i dims) {
    sources.push_back(makeWhiteNoise(dims, VoxelType::kU16, sources.size() + 1));
    return sources.back().get();
  };
  for (int level = 0; level < pyramid.levels(); ++level) {
    const LevelLayout& at = pyramid.level(level);
    MemorySource* const means = noise(at.blocks.dims);
    MemorySource* const spread = at.numbers == 2 ? noise(at.blocks.dims) : nullptr;
    levels.push_back(means);
    spreads.push_back(spread);
    read.push_back({means, at.blocks, spread});
  }
  std::mt19937_64 random(5);
  WorkerPool pool(2);
  VolumeBuffer blocks(read, 256 << 10, VolumeBuffer::Cold::kPacked);
  TextureBuffer buffer(blocks, pool, 4 << 20);
  ChunkNames names;
  const PageGeometry page{{8, 8, 1}, 2, 64};
  std::set<int32_t> seen;
  for (int trial = 0; trial < 20; ++trial) {
    const TexturePlan plan = planTextures(pyramid, randomCut(pyramid, 0.7, random), page,
                                          planOptions(pyramid.finest(), Algorithm::kMerged));
    const auto texels = buffer.acquire(plan, names.namesOf(plan), allChunks(plan));
    uint64_t bytes = 0;
    for (size_t i = 0; i < texels.size(); ++i) {
      const ChunkPosition chunk(i);
      const int32_t level = plan.blocks[plan.chunks[chunk].blocks.front()].name.level;
      seen.insert(level);
      bytes += texels[i]->byte_count;
      ASSERT_EQ(texels[i]->has_spread, level > 0 && numbers == 2);
      if (texels[i]->has_spread) {
        expectTexels(plan, chunk, numberOf(*texels[i], 0), levels);
        expectTexels(plan, chunk, numberOf(*texels[i], 1), spreads);
      } else {
        expectTexels(plan, chunk, *texels[i], levels);
      }
    }
    if (HasFatalFailure()) FAIL() << "trial " << trial;
    EXPECT_EQ(plan.bytes(), bytes) << "pages are counted as they are filled";
    // What interpolation takes of a block is there.
    for (const TextureBlock& block : plan.blocks)
      EXPECT_TRUE(block.voxels.contains(pyramid.of(block.name).voxelsUnder(block.cells)));
    // No cluster needs more pages than the cache has.
    for (const Cluster& cluster : plan.clusters) {
      int64_t pages = 0;
      for (const ChunkPosition chunk : cluster.chunks) pages += plan.chunks[chunk].pages;
      EXPECT_LE(pages, page.pages);
    }
  }
  EXPECT_EQ(seen.size(), 3U);
  const CacheCounters counters = blocks.counters();
  EXPECT_LE(counters.peak_bytes, counters.budget_bytes);
}
INSTANTIATE_TEST_SUITE_P(Numbers, TextureBufferCutTest, testing::Values(1, 2));

// Chunks large enough for their memory to be kept and passed on from one to the next.
TEST(TextureBuffer, memoryThatIsPassedOnLeavesNothingOfItsLastChunk) {
  const auto source = makeWhiteNoise({2 * 63 + 1, 64, 64}, VoxelType::kU8, 3);
  const BlockLayout layout = blockLayout({2 * 63 + 1, 64, 64}, 64, 0);
  const PageGeometry page{{64, 32, 32}, 1, 16};
  const std::vector<Box3> shown = {allCells(layout),
                                   {{0, 0, 5}, {126, 63, 12}},
                                   {{0, 0, 20}, {126, 63, 60}},
                                   {{3, 0, 0}, {110, 50, 63}}};
  WorkerPool pool(2);
  VolumeBuffer blocks(*source, layout, 4 << 20);
  TextureBuffer buffer(blocks, pool, 512 << 10);  // room for a chunk of two whole blocks
  ChunkNames names;
  for (int turn = 0; turn < 3; ++turn)
    for (const Box3& box : shown) {
      std::vector<ObjectBlock> visible;
      for (int64_t block = 0; block < 2; ++block)
        visible.push_back(
            objectBlock(layout, block, intersect(box, layout.ownedCells(layout.indexOf(block)))));
      const TexturePlan plan = planTextures(layout, visibleBlocksOf(layout, visible), page,
                                            planOptions(layout, Algorithm::kMerged));
      const auto texels = buffer.acquire(plan, names.namesOf(plan), allChunks(plan));
      for (size_t i = 0; i < texels.size(); ++i)
        expectTexels(plan, ChunkPosition(i), *texels[i], *source);
    }
  EXPECT_GT(buffer.counters().evictions, 4U);
}

TEST_F(TextureBufferTest, whatPagesAddIsZero) {
  const PageGeometry page{{16, 8, 4}, 1, 32};
  VisibleBlocks one = visibleBlocksOf(layout_, {objectBlock(layout_, 0, {{0, 0, 0}, {7, 7, 2}})});
  const TexturePlan plan =
      planTextures(layout_, one, page, planOptions(layout_, Algorithm::kTrimmed));
  const auto buffer = bufferOf(counted_, 24);
  const auto texels = buffer->acquire(plan, chunk_names_.namesOf(plan), allChunks(plan));
  ASSERT_EQ(texels[0]->storage_vox, (Vec3i{16, 8, 4}));
  for (int64_t z = 0; z < 4; ++z)
    for (int64_t y = 0; y < 8; ++y)
      for (int64_t x = 0; x < 16; ++x)
        if (x >= 8 || z >= 3) {
          EXPECT_EQ(texels[0]->bytes[static_cast<size_t>((z * 8 + y) * 16 + x)], std::byte{0});
        }
}

}  // namespace
}  // namespace sluice
