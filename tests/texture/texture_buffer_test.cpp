#include "src/texture/texture_buffer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <malloc.h>

#include <algorithm>
#include <cstring>
#include <future>
#include <numeric>
#include <thread>

#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/texture/chunk_names.h"
#include "src/texture/fill_chunk.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/texture/random_plan.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<int64_t> allChunks(const TexturePlan& plan) {
  std::vector<int64_t> chunks(plan.chunks.size());
  std::iota(chunks.begin(), chunks.end(), 0);
  return chunks;
}

// Each texel of each texture block against the voxel that it stands for, found the long way; all
// others are 0.
void expectTexels(const TexturePlan& plan, int64_t position, const ChunkTexels& texels,
                  const MemorySource& source) {
  const Chunk& chunk = plan.chunks[static_cast<size_t>(position)];
  const size_t size = bytesPerVoxel(deviceMap(source.layout()).type);
  const size_t stored_size = bytesPerVoxel(source.layout().type);
  const Vec3i dims = source.layout().dims;
  ASSERT_EQ(texels.storage_vox, plan.page.pageGridOf(chunk.size_vox) * plan.page.size_vox);
  ASSERT_EQ(texels.byte_count, static_cast<size_t>(volume(texels.storage_vox)) * size);
  std::vector<std::byte> expected(size);
  std::vector<bool> covered(static_cast<size_t>(volume(texels.storage_vox)));
  for (const int64_t b : chunk.blocks) {
    const TextureBlock& block = plan.blocks[static_cast<size_t>(b)];
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
              << "block " << block.block << " axis " << axis << " texel " << t.x << ' ' << t.y
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

// Memory comes with junk in it, as that of an evicted chunk does.
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
        const TexturePlan plan = planTextures(layout, randomClassification(layout, 0.5, random),
                                              page, planOptions(layout, algorithm));
        for (const TextureBlock& block : plan.blocks)
          ++axes_seen[static_cast<size_t>(block.trimming_axis)];
        WorkerPool pool(3);
        VolumeBuffer blocks(*source, layout, 1 << 20);
        TextureBuffer buffer(blocks, pool, 16 << 20);
        ChunkNames names;
        const std::vector<int64_t> chunks = allChunks(plan);
        const auto texels = buffer.acquire(plan, names.namesOf(plan), chunks);
        ASSERT_EQ(texels.size(), chunks.size());
        for (size_t i = 0; i < chunks.size(); ++i) {
          expectTexels(plan, chunks[i], *texels[i], *source);
          if (HasFatalFailure()) FAIL() << name(type) << ' ' << name(algorithm) << ' ' << ghost;
        }
      }
  for (const int count : axes_seen) EXPECT_GT(count, 50);
}

TEST(TextureBuffer, smallVolumesArePaddedByTheirBorder) {
  // One block of 8 over a volume of 3 x 2 x 5 voxels.
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
      expectTexels(plan, 0, *texels.at(0), *source);
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

// Chunks large enough to be kept where memory is passed on from one to the next.
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
  TextureBuffer buffer(blocks, pool, 512 << 10);  // one chunk of two whole blocks
  ChunkNames names;
  for (int turn = 0; turn < 3; ++turn)
    for (const Box3& box : shown) {
      std::vector<ObjectBlock> visible;
      for (int64_t block = 0; block < 2; ++block)
        visible.push_back(
            objectBlock(layout, block, intersect(box, layout.ownedCells(layout.indexOf(block)))));
      const TexturePlan plan = planTextures(layout, classificationOf(layout, visible), page,
                                            planOptions(layout, Algorithm::kMerged));
      const auto texels = buffer.acquire(plan, names.namesOf(plan), allChunks(plan));
      for (size_t i = 0; i < texels.size(); ++i)
        expectTexels(plan, static_cast<int64_t>(i), *texels[i], *source);
    }
  EXPECT_GT(buffer.counters().evictions, 4U);
}

// --- accounting: 4 x 3 x 2 whole blocks of 8^3 bytes, a chunk each

constexpr Vec3i kDims{4 * 7 + 1, 3 * 7 + 1, 2 * 7 + 1};
constexpr uint64_t kChunkBytes = 512;

class TextureBufferTest : public testing::Test {
 protected:
  std::unique_ptr<TextureBuffer> bufferOf(VolumeSource& source, uint64_t chunks,
                                          uint64_t blocks = 24) {
    blocks_ = std::make_unique<VolumeBuffer>(source, layout_, blocks * kChunkBytes);
    return std::make_unique<TextureBuffer>(*blocks_, pool_, chunks * kChunkBytes);
  }
  std::vector<ChunkTexelsPtr> acquire(TextureBuffer& buffer, std::vector<int64_t> chunks) {
    return buffer.acquire(plan_, names_, chunks);
  }

  const BlockLayout layout_ = blockLayout(kDims, 8, 0);
  const PageGeometry page_{{8, 8, 1}, 1, 32};
  const std::unique_ptr<MemorySource> memory_ = makeWhiteNoise(kDims, VoxelType::kU8, 1);
  CountingSource counted_{*memory_};
  const TexturePlan plan_ =
      planTextures(layout_, allBlack(layout_), page_, planOptions(layout_, Algorithm::kTrimmed));
  ChunkNames chunk_names_;
  const std::vector<uint64_t> names_ = chunk_names_.namesOf(plan_);
  WorkerPool pool_{2};
  std::unique_ptr<VolumeBuffer> blocks_;
};

TEST_F(TextureBufferTest, hitsAndMissesHaveTheNumbersOfTheirDefinition) {
  const auto buffer = bufferOf(counted_, 6);
  acquire(*buffer, {0, 1, 2, 3});   // 4 misses
  acquire(*buffer, {3, 2, 1, 0});   // 4 hits
  acquire(*buffer, {0, 4, 8, 12});  // 1 hit, 3 misses: 3 goes (least recently used)
  acquire(*buffer, {3});            // a miss, loaded before
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.requests, 13U);
  EXPECT_EQ(c.hits, 5U);
  EXPECT_EQ(c.misses, 8U);
  EXPECT_EQ(c.loads, 8U);
  EXPECT_EQ(c.redundant_loads, 1U);
  EXPECT_EQ(c.evictions, 2U);
  EXPECT_EQ(c.resident, 6U);
  EXPECT_EQ(c.current_bytes, 6 * kChunkBytes);
  EXPECT_EQ(c.peak_bytes, 6 * kChunkBytes);
  EXPECT_EQ(c.budget_bytes, 6 * kChunkBytes);
  EXPECT_EQ(c.decoded_bytes, 8 * kChunkBytes);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  // The level below, as second observer: each chunk is one block, and all blocks fit there.
  EXPECT_EQ(blocks_->counters().requests, 8U);
  EXPECT_EQ(blocks_->counters().loads, 7U);
}

TEST_F(TextureBufferTest, chunksComeInTheOrderAskedFor) {
  const auto buffer = bufferOf(counted_, 24);
  acquire(*buffer, {2, 7});
  const std::vector<int64_t> wanted{7, 0, 2, 23, 5};
  const auto texels = acquire(*buffer, wanted);
  for (size_t i = 0; i < wanted.size(); ++i) {
    expectTexels(plan_, wanted[i], *texels[i], *memory_);
    if (HasFatalFailure()) FAIL() << "chunk " << wanted[i];
  }
}

TEST_F(TextureBufferTest, neighboursAlongXAreReadTogether) {
  const auto buffer = bufferOf(counted_, 24, 64);
  acquire(*buffer, {5, 2, 0, 3, 1, 4});
  EXPECT_EQ(counted_.counts().calls, 2);  // rows 0..3 and 4..5
}

// Rows of four blocks: for three threads half of level 2 is one block each, and all of it is no
// more than two rows at once.
TEST_F(TextureBufferTest, wholeRowsAreReadTogetherAlsoByFewerThreads) {
  const auto buffer = bufferOf(counted_, 24, 10);
  acquire(*buffer, allChunks(plan_));
  EXPECT_EQ(counted_.counts().calls, 6);
  EXPECT_LE(counted_.counts().max_at_once, 2);
}

TEST_F(TextureBufferTest, aPlanThatRepeatsARecipeFindsItsBytes) {
  const auto buffer = bufferOf(counted_, 24);
  acquire(*buffer, allChunks(plan_));
  buffer->resetCounters();
  counted_.reset();
  // The same but for one block, which is trimmed.
  Classification changed = allBlack(layout_);
  changed.visible[9] = objectBlock(layout_, 9, {{7, 14, 0}, {14, 21, 3}});
  const TexturePlan plan =
      planTextures(layout_, changed, page_, planOptions(layout_, Algorithm::kTrimmed));
  const auto texels = buffer->acquire(plan, chunk_names_.namesOf(plan), allChunks(plan));
  EXPECT_EQ(buffer->counters().hits, 23U);
  EXPECT_EQ(buffer->counters().loads, 1U);
  EXPECT_EQ(counted_.counts().calls, 0);  // its block is at level 2 still
  expectTexels(plan, 9, *texels[9], *memory_);
}

TEST_F(TextureBufferTest, heldChunksStay) {
  const auto buffer = bufferOf(counted_, 3);
  auto held = acquire(*buffer, {0});
  for (const int64_t chunk : {1, 2, 3, 4, 5}) acquire(*buffer, {chunk});
  buffer->resetCounters();
  EXPECT_EQ(acquire(*buffer, {0})[0], held[0]);
  EXPECT_EQ(buffer->counters().hits, 1U);
}

TEST_F(TextureBufferTest, moreThanTheBudgetAtOnceIsAnErrorThatSaysHowMuch) {
  const auto buffer = bufferOf(counted_, 2);
  acquire(*buffer, {9});
  try {
    acquire(*buffer, {0, 1, 2});
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("1.0 KiB"), HasSubstr("--memory")));
  }
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  EXPECT_EQ(buffer->counters().failures, 3U);
  EXPECT_EQ(acquire(*buffer, {0, 1}).size(), 2U);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  EXPECT_LE(buffer->counters().peak_bytes, 2 * kChunkBytes);
}

TEST_F(TextureBufferTest, aFailedReadLeavesTheBufferUsable) {
  FailingSource failing(counted_, FailingSource::Failure::kError, 1);
  const auto buffer = bufferOf(failing, 24);
  EXPECT_THROW(acquire(*buffer, {0, 5, 10, 15}), Error);
  CacheCounters c = buffer->counters();
  EXPECT_GE(c.failures, 1U);
  EXPECT_EQ(c.resident, 4 - c.failures);  // what other threads filled meanwhile is kept
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  const auto texels = acquire(*buffer, {0, 5, 10, 15});
  expectTexels(plan_, 5, *texels[1], *memory_);
  c = buffer->counters();
  EXPECT_EQ(c.loads, 4U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_THAT(blocks_->counters().brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, anInterruptionPassesThrough) {
  FunctionSource source(memory_->layout(), [](int64_t, Vec3i) -> double { throw Interrupted(); });
  const auto buffer = bufferOf(source, 24);
  EXPECT_THROW(acquire(*buffer, {0, 1, 2}), Interrupted);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

// --- ahead of the one who asks

TEST_F(TextureBufferTest, whatWasBegunIsThereWhenItIsAskedFor) {
  const auto buffer = bufferOf(counted_, 24);
  const auto first = buffer->begin(plan_, names_, std::vector<int64_t>{0, 1, 2});
  const auto second = buffer->begin(plan_, names_, std::vector<int64_t>{2, 3});
  const auto last = buffer->finish(second);
  expectTexels(plan_, 2, *last[0], *memory_);
  expectTexels(plan_, 3, *last[1], *memory_);
  EXPECT_EQ(buffer->finish(first)[2], last[0]);
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.loads, 4U);
  EXPECT_EQ(c.hits + c.coalesced, 1U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, aheadIsNotBegunWithoutRoom) {
  const auto buffer = bufferOf(counted_, 3);
  const auto first = buffer->begin(plan_, names_, std::vector<int64_t>{0, 1});
  EXPECT_EQ(buffer->tryBegin(plan_, names_, std::vector<int64_t>{2, 3}), nullptr);
  const auto second = buffer->tryBegin(plan_, names_, std::vector<int64_t>{1, 2});
  ASSERT_NE(second, nullptr);  // 1 is under way already
  EXPECT_THROW(buffer->begin(plan_, names_, std::vector<int64_t>{4}), Error);
  buffer->finish(first);
  buffer->finish(second);
  EXPECT_NE(buffer->begin(plan_, names_, std::vector<int64_t>{4, 5, 6}), nullptr);
  EXPECT_EQ(buffer->counters().peak_bytes, 3 * kChunkBytes);
}

TEST_F(TextureBufferTest, cancelledChunksAreNotReadAndCanBeAskedForAgain) {
  std::promise<void> go;
  std::shared_future<void> may_go = go.get_future().share();
  FunctionSource stalled(memory_->layout(), [&](int64_t, Vec3i) -> double {
    may_go.wait();
    return 7;
  });
  const auto buffer = bufferOf(stalled, 24);
  // A pool of 2 has one worker: it stalls in the first block, the rest is not begun.
  const auto batch = buffer->begin(plan_, names_, std::vector<int64_t>{0, 4, 8, 12, 16});
  while (blocks_->counters().requests == 0) std::this_thread::yield();
  buffer->cancel(batch);
  go.set_value();
  const auto texels = acquire(*buffer, {4, 8, 0});
  EXPECT_EQ(texels[0]->bytes[0], std::byte{7});
  const CacheCounters c = buffer->counters();
  EXPECT_EQ(c.failures, 4U);
  EXPECT_THAT(c.brokenIdentity(), IsEmpty());
  EXPECT_EQ(blocks_->counters().loads, 3U);  // the one under way and the two asked for again
}

TEST_F(TextureBufferTest, aFailureAheadSurfacesWhereItIsAskedFor) {
  FailingSource failing(counted_, FailingSource::Failure::kError, 0);
  const auto buffer = bufferOf(failing, 24);
  const auto ahead = buffer->begin(plan_, names_, std::vector<int64_t>{0});
  EXPECT_THROW(buffer->finish(ahead), Error);
  EXPECT_EQ(acquire(*buffer, {0}).size(), 1U);
}

TEST_F(TextureBufferTest, destructionWaitsForWhatIsUnderWay) {
  for (int i = 0; i < 50; ++i) {
    const auto buffer = bufferOf(counted_, 24);
    const auto batch = buffer->begin(plan_, names_, allChunks(plan_));
    buffer->cancel(batch);
  }
}

TEST_F(TextureBufferTest, batchesBegunFinishedAndCancelledAtRandomKeepBudgetAndTexels) {
  WorkerPool many(5);
  for (uint32_t seed = 0; seed < 4; ++seed) {
    blocks_ = std::make_unique<VolumeBuffer>(counted_, layout_, 20 * kChunkBytes,
                                             VolumeBuffer::Cold::kPacked);
    TextureBuffer buffer(*blocks_, many, 9 * kChunkBytes);
    std::mt19937 random(seed);
    struct Begun {
      std::vector<int64_t> chunks;
      TextureBuffer::BatchPtr batch;
    };
    std::vector<Begun> begun;
    const auto takeOne = [&] {
      const size_t which = random() % begun.size();
      Begun taken = std::move(begun[which]);
      begun.erase(begun.begin() + static_cast<ptrdiff_t>(which));
      return taken;
    };
    for (int i = 0; i < 600; ++i) {
      std::vector<int64_t> chunks(1 + random() % 3), soon(random() % 5);
      for (int64_t& chunk : chunks) chunk = static_cast<int64_t>(random() % plan_.chunks.size());
      for (int64_t& chunk : soon) chunk = static_cast<int64_t>(random() % plan_.chunks.size());
      const auto batch = buffer.tryBegin(plan_, names_, chunks, soon);
      if (batch != nullptr) begun.push_back({chunks, batch});
      if (!begun.empty() && random() % 3 == 0) buffer.cancel(takeOne().batch);
      if (!begun.empty() && random() % 2 == 0) {
        const Begun taken = takeOne();
        const auto texels = buffer.finish(taken.batch);
        expectTexels(plan_, taken.chunks[0], *texels[0], *memory_);
        if (HasFatalFailure()) return;
      }
      ASSERT_LE(buffer.counters().current_bytes, 9 * kChunkBytes);
    }
    for (const Begun& rest : begun) buffer.cancel(rest.batch);
    buffer.waitUntilIdle();
    EXPECT_THAT(buffer.counters().brokenIdentity(), IsEmpty());
    EXPECT_THAT(blocks_->counters().brokenIdentity(), IsEmpty());
    EXPECT_LE(buffer.counters().peak_bytes, 9 * kChunkBytes);
    EXPECT_LE(blocks_->counters().peak_bytes, 20 * kChunkBytes);
  }
}

TEST_F(TextureBufferTest, oneChunkTwiceInACallIsLoadedOnce) {
  const auto buffer = bufferOf(counted_, 2);
  const auto texels = acquire(*buffer, {4, 4, 4});
  EXPECT_EQ(texels[0], texels[1]);
  EXPECT_EQ(texels[0], texels[2]);
  EXPECT_EQ(buffer->counters().loads, 1U);
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  for (const int64_t chunk : {1, 2, 3, 4}) acquire(*buffer, {chunk});
  EXPECT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
}

TEST_F(TextureBufferTest, budgetsOfBothLevelsHoldOverManyFrames) {
  constexpr uint64_t kChunks = 5, kBlocks = 4;
  const auto buffer = bufferOf(counted_, kChunks, kBlocks);
  std::mt19937 random(1);
  for (int frame = 0; frame < 200; ++frame) {
    std::vector<int64_t> wanted(1 + random() % kChunks);
    for (int64_t& chunk : wanted) chunk = static_cast<int64_t>(random() % plan_.chunks.size());
    const auto texels = acquire(*buffer, wanted);
    expectTexels(plan_, wanted[0], *texels[0], *memory_);
    ASSERT_LE(buffer->counters().current_bytes, kChunks * kChunkBytes);
    ASSERT_THAT(buffer->counters().brokenIdentity(), IsEmpty());
  }
  EXPECT_LE(blocks_->counters().peak_bytes, kBlocks * kChunkBytes);
  EXPECT_THAT(blocks_->counters().brokenIdentity(), IsEmpty());
  EXPECT_GT(buffer->counters().evictions, 0U);
}

TEST_F(TextureBufferTest, whatPagesAddIsZero) {
  const PageGeometry page{{16, 8, 4}, 1, 32};
  Classification one = classificationOf(layout_, {objectBlock(layout_, 0, {{0, 0, 0}, {7, 7, 2}})});
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
