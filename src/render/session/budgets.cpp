#include "src/render/session/budgets.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "src/base/values/bytes.h"
#include "src/index/volume_boxes.h"
#include "src/volume/block_side.h"
#include "src/volume/volume_buffer.h"

namespace sluice {
namespace {

// Growing boxes get one part in so many of the memory beyond the least, and the voxels that they
// are made of another. Half of the first is for trees of all boxes, half for the boxes that frames
// draw.
constexpr uint64_t kBoxShare = 8;

constexpr int kReadsInFlight = 4;

// The largest chunk: two whole blocks side by side, in whole pages.
uint64_t largestChunkBytes(const PageGeometry& page, const BufferNeeds& needs) {
  const int64_t side = needs.block_vox;
  return static_cast<uint64_t>(page.pagesOf(Vec3i{2 * side, side, side}) * page.pageBytes() *
                               needs.numbers);
}

// Bytes that a reading thread has under way.
uint64_t threadBytes(const PageGeometry& page, const BufferNeeds& needs) {
  const int64_t side = needs.block_vox;
  const auto block_bytes =
      static_cast<uint64_t>(volume(Vec3i{side, side, side}) * page.bytes_per_voxel * needs.numbers);
  return 2 * block_bytes + VolumeBuffer::kScratchBytes + needs.source_thread_bytes +
         needs.growing_bytes;
}

// Bytes of the tables that a borrowing device makes of the resident chunks. A chunk of several
// pages has no more bricks than these have one by one.
uint64_t tableBytes(const PageGeometry& page) {
  // Neighbouring bricks share a plane of voxels, so that a page of n voxels has n - 1 cells.
  int64_t bricks = 1;
  for (int a = 0; a < 3; ++a)
    bricks *= ceilDiv(std::max<int64_t>(page.size_vox[a] - 1, 1), kTableBrickSide);
  constexpr int64_t kMargin = 4;  // bytes beyond the last brick, of each chunk
  return static_cast<uint64_t>(page.pages * (bricks * (2 * page.bytes_per_voxel + 1) + kMargin));
}

std::string shortageLine(const MemoryShortage::Bytes& of_one, size_t channels,
                         std::optional<uint64_t> least_bytes) {
  const std::string sharing =
      channels == 1 ? ""
                    : fmt::format("{} channels share the memory evenly, and of each ", channels);
  return fmt::format(
      "--memory {} is too small: {}{} of {} and {} of buffers are the least that works; "
      "give --memory {} or fewer --pages",
      formatBytes(channels * of_one.memory), sharing, formatBytes(of_one.textures),
      of_one.texels == TexelPlace::kBorrowed ? "chunks" : "textures", formatBytes(of_one.buffers),
      least_bytes.value_or(channels * (of_one.textures + of_one.buffers)));
}

}  // namespace

int readsAtOnce(const VolumeSource& source, int threads) {
  return std::max({threads, kReadsInFlight, source.distantReads()});
}

BufferNeeds needsOf(const TimeStep& step, Partition partition, uint64_t beside_bytes) {
  const VolumeLayout& volume = step.source->layout();
  const BlockLayout& layout = step.ranges->layout;
  BufferNeeds needs{.block_vox = blockSide(layout, volume.levels),
                    .source_thread_bytes = step.source->heldBytesAThread(),
                    .beside_bytes = beside_bytes};
  if (partition == Partition::kBoxes) needs.growing_bytes = growingBytes(volume, layout);
  // Blocks of several levels are never cut to the volume's size (block_side.h).
  if (!step.coarser.empty()) needs.block_vox = layout.size;
  const auto readsFrom = [&](const VolumeSource& source) {
    needs.source_thread_bytes = std::max(needs.source_thread_bytes, source.heldBytesAThread());
  };
  for (const CoarserStep& coarser : step.coarser) {
    readsFrom(*coarser.source);
    if (coarser.spreads == nullptr) continue;
    readsFrom(*coarser.spreads);
    needs.numbers = 2;
  }
  return needs;
}

uint64_t leastBufferBytes(const PageGeometry& page, const BufferNeeds& needs) {
  return needs.beside_bytes + 2 * largestChunkBytes(page, needs) + 2 * threadBytes(page, needs);
}

uint64_t textureMemoryBytes(const PageGeometry& page, TexelPlace texels) {
  const auto cache_bytes = static_cast<uint64_t>(page.cacheBytes());
  switch (texels) {
    case TexelPlace::kInMemory:
      return cache_bytes + spareTextureBytes(cache_bytes);
    case TexelPlace::kBorrowed:
      return cache_bytes + tableBytes(page);
    case TexelPlace::kOnDevice:
      break;
  }
  return 0;
}

MemoryShortage::MemoryShortage(const Bytes& of_one, size_t channels,
                               std::optional<uint64_t> least_bytes)
    : Error(shortageLine(of_one, channels, least_bytes), Kind::kMemory), of_one_(of_one) {}

uint64_t leastMemoryBytes(const std::function<uint64_t(uint64_t memory_bytes)>& needOf,
                          uint64_t refused) {
  // Less than the need of a memory that is refused is refused, too: the steps meet the least from
  // below. Where the need grows nearly as fast as the memory, they double it and halve back.
  constexpr int kSteps = 12;
  uint64_t need = needOf(refused);
  for (int i = 0; i < kSteps; ++i) {
    const uint64_t memory = need;
    need = needOf(memory);
    if (need <= memory) return memory;
    refused = memory;
  }
  uint64_t enough = 2 * refused;
  for (; needOf(enough) > enough; enough *= 2) {
    // Near the largest number the doubling would wrap.
    if (enough > UINT64_MAX / 2) return enough;
    refused = enough;
  }
  while (enough - refused > 1) {
    const uint64_t middle = refused + (enough - refused) / 2;
    (needOf(middle) <= middle ? enough : refused) = middle;
  }
  return enough;
}

Budgets shareMemory(uint64_t memory_bytes, const PageGeometry& page, TexelPlace texels,
                    const BufferNeeds& needs, int most_readers) {
  Budgets budgets;
  budgets.texture_cache = static_cast<uint64_t>(page.cacheBytes());
  const uint64_t least_buffers = leastBufferBytes(page, needs);
  const uint64_t textures = textureMemoryBytes(page, texels);
  // Beyond this check none of the differences below can wrap.
  if (memory_bytes < textures + least_buffers)
    throw MemoryShortage({memory_bytes, textures, least_buffers, texels});
  // Beyond the least: an eighth for growing boxes, one for their voxels and one for a source if
  // these can use it, a third of the remainder for chunks, the rest for blocks and for more
  // readers.
  uint64_t surplus = memory_bytes - textures - least_buffers;
  if (needs.growing_bytes > 0) {
    budgets.boxes = surplus / kBoxShare;
    budgets.growing = std::min(surplus / kBoxShare, kMostGrowingBytes);
  }
  surplus -= budgets.boxes + budgets.growing;
  budgets.texture_buffer = 2 * largestChunkBytes(page, needs) + surplus / 3;
  // A source that keeps no chunks has no use for memory.
  const uint64_t source_surplus = needs.source_thread_bytes > 0 ? surplus / 8 : 0;
  const uint64_t rest = memory_bytes - textures - needs.beside_bytes - budgets.texture_buffer -
                        source_surplus - budgets.boxes - budgets.growing;
  // The drawing thread helps to read, and needs its own scratch.
  const auto most_threads = static_cast<uint64_t>(most_readers) + 1;
  const uint64_t threads = std::min(most_threads, rest / threadBytes(page, needs));
  budgets.readers = static_cast<int>(threads) - 1;
  budgets.scratch = threads * VolumeBuffer::kScratchBytes;
  budgets.source = threads * needs.source_thread_bytes + source_surplus;
  budgets.growing += threads * needs.growing_bytes;
  if (texels == TexelPlace::kBorrowed) budgets.borrowed = budgets.texture_cache;
  // Borrowed bytes belong to level 3, which must hold them in addition to the chunks that it fills.
  budgets.texture_buffer += budgets.borrowed;
  budgets.volume_buffer =
      rest - budgets.scratch - threads * (needs.source_thread_bytes + needs.growing_bytes);
  return budgets;
}

}  // namespace sluice
