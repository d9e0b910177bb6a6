#include "src/library/drawing/scene/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/classify/blocks/classification.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/render/blocks/look.h"
#include "src/render/blocks/losses/spread_tally.h"
#include "src/volume/block_side.h"
#include "src/volume/ranges/learnt_ranges.h"

namespace sluice {
namespace {

// The share of the memory for textures if they live in it. Elsewhere their memory is not known to
// the program, and any GPU of the last ten years has this much.
constexpr uint64_t kTextureShare = 4;
constexpr uint64_t kDeviceTextureBytes = uint64_t{1} << 30;

// The pages of a block.
int64_t leastPages(const PageGeometry& page, const BufferNeeds& needs) {
  const Vec3i block{needs.block_vox, needs.block_vox, needs.block_vox};
  return static_cast<int64_t>(
      std::bit_ceil(static_cast<uint64_t>(page.pagesOf(block) * needs.numbers)));
}

// Never fewer than a block takes.
int64_t defaultPages(const PageGeometry& page, const BufferNeeds& needs, Vec3i dims,
                     uint64_t memory_bytes) {
  const auto page_bytes = static_cast<uint64_t>(page.pageBytes());
  const auto least = static_cast<uint64_t>(leastPages(page, needs));
  // Blocks share planes and are padded: twice the volume's own pages holds them all.
  const Vec3i bounded = min(dims, Vec3i{1 << 20, 1 << 20, 1 << 20});
  const double whole = std::min(2.0 * static_cast<double>(page.pagesOf(bounded)), 1e15);
  const uint64_t most = std::min(memory_bytes / kTextureShare, kDeviceTextureBytes) / page_bytes;
  uint64_t pages = std::min(std::bit_floor(std::max<uint64_t>(1, most)),
                            std::bit_ceil(static_cast<uint64_t>(whole)));
  pages = std::max(pages, least);
  // What is held beside is off `memory_bytes` already.
  const uint64_t buffers = leastBufferBytes(page, needs);
  const auto needed = [&] {
    PageGeometry geometry = page;
    geometry.pages = static_cast<int64_t>(pages);
    return textureMemoryBytes(geometry, TexelPlace::kInMemory) + buffers;
  };
  while (pages > least && needed() > memory_bytes) pages /= 2;
  return static_cast<int64_t>(pages);
}

// A planned block. Measured with blocks of 8 voxels, each in a chunk with one other: 820 bytes.
// With surfaces, LostTally notes about 60 more.
constexpr uint64_t kPlannedBlockBytes = 1000;

// The most blocks that a cut may hold at once, whatever the view.
uint64_t blocksOfCut(const IndexedVolume& volume, const CutOptions& cut) {
  if (cut.level && *cut.level < volume.pyramid->levels())
    return static_cast<uint64_t>(volume.pyramid->level(*cut.level).blocks.blockCount());
  const int64_t side = volume.layout.size;
  const uint64_t block_bytes =
      static_cast<uint64_t>(sluice::volume({side, side, side})) * bytesPerVoxel(volume.map.type);
  return cut.most_held_bytes / block_bytes + 1;
}

// The spreads of coarse blocks that were read, of which each step has its own.
uint64_t spreadBytes(const IndexedVolume& volume) {
  if (volume.pyramid == nullptr) return 0;
  double blocks = 0;
  for (int level = 1; level < volume.pyramid->levels(); ++level)
    if (const LevelLayout& at = volume.pyramid->level(level); at.numbers == 2)
      blocks += static_cast<double>(at.blocks.blockCount());
  blocks *= static_cast<double>(volume.source->layout().time_steps);
  const auto most = static_cast<double>(SpreadTally::kMostBlocks);
  return static_cast<uint64_t>(std::min(blocks, most)) * SpreadTally::kBlockBytes;
}

// The ranges of blocks that become known as they are read: noted, and in two states of all ranges.
uint64_t learntBytes(const IndexedVolume& volume) {
  const SliceRanges& ranges = volume.index->ranges;
  if (ranges.unknown.empty()) return 0;
  const uint64_t block =
      (1 + 3 * static_cast<uint64_t>(ranges.layout.planes())) * 2 * bytesPerVoxel(ranges.map.type);
  const uint64_t noted = std::min(ranges.unknown.size() * block, LearntRanges::kMostBytes);
  return 3 * noted + 2 * ranges.bytes();
}

}  // namespace

uint64_t memoryBudget(const MachineOptions& machine) {
  return machine.memory_bytes != 0 ? machine.memory_bytes : availableMemoryBytes() / 2;
}

PageGeometry pageShape(const MachineOptions& machine, const ValueMap& map) {
  PageGeometry page;
  page.bytes_per_voxel = static_cast<int64_t>(bytesPerVoxel(map.type));
  const char* standard = page.bytes_per_voxel == 1   ? "sparse-8"
                         : page.bytes_per_voxel == 2 ? "sparse-16"
                                                     : "sparse-32";
  page.size_vox = machine.page_vox.value_or(findPageConfiguration(standard)->geometry.size_vox);
  return page;
}

MachineOptions withBlocksOfFirst(MachineOptions machine, const VolumeLayout& own,
                                 const VolumeLayout& first) {
  if (!machine.block && isSameGrid(own, first))
    machine.block = blockSizeFor(pageShape(machine, deviceMap(first)).size_vox);
  return machine;
}

std::string smallBlocksNote(const IndexedVolume& volume) {
  const VolumeLayout& layout = volume.source->layout();
  const uint64_t value_bytes = bytesPerVoxel(volume.map.type);
  // The least and the greatest value of a block and of each of its planes.
  const uint64_t block_bytes =
      kPlannedBlockBytes + sizeof(int64_t) +
      2 * value_bytes * (1 + 3 * static_cast<uint64_t>(volume.layout.planes()));
  const auto blocks = static_cast<uint64_t>(volume.layout.blockCount());
  const auto voxel_bytes =
      static_cast<uint64_t>(sluice::volume(layout.dims)) * bytesPerVoxel(layout.type);
  constexpr uint64_t kMuch = uint64_t{256} << 20, kTimes = 8;
  if (blocks < kMuch / block_bytes || blocks / kTimes < voxel_bytes / block_bytes) return "";
  // The chunk of a block has whole pages, however small it is.
  const uint64_t all_bytes =
      blocks * (block_bytes + static_cast<uint64_t>(volume.page.pageBytes()));
  return fmt::format(
      "{}: --block {} makes {} blocks, which take up to {} of memory if --memory has it, {} "
      "times as much as the voxels; larger blocks draw the same picture in less time",
      volume.name, volume.layout.size, blocks, formatBytes(all_bytes), all_bytes / voxel_bytes);
}

int64_t pageCount(const MachineOptions& machine, const IndexedVolume& volume,
                  uint64_t beside_bytes) {
  if (machine.pages) return *machine.pages;
  // The partition makes no difference, so that a plan holds for both.
  const BufferNeeds needs = needsOf(volume.step(), Partition::kBlocks, 0);
  const uint64_t memory_bytes = memoryBudget(machine);
  return defaultPages(volume.page, needs, volume.source->layout().dims,
                      memory_bytes - std::min(memory_bytes, beside_bytes));
}

uint64_t planBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                   const FrameOptions& frame, WorkerPool& pool) {
  const auto all = static_cast<uint64_t>(volume.layout.blockCount());
  uint64_t blocks = all;
  if (!loadsWholeBlocks(frame.algorithm) && !volume.stand_in) {  // of whose blocks nothing is known
    const SliceRanges& ranges = volume.index->ranges;
    const Look look = makeLook(volume.step(), transfer, frame.mode);
    blocks = static_cast<uint64_t>(
        countVisible(ranges, look.table, cropCells(frame, ranges.layout.dims), pool));
    // Another step may show more.
    if (volume.source->layout().time_steps > 1) blocks = std::min(2 * all, 3 * blocks);
  }
  if (frame.cut && volume.pyramid) blocks = std::min(blocks, blocksOfCut(volume, *frame.cut));
  return blocks * kPlannedBlockBytes + spreadBytes(volume) + learntBytes(volume);
}

uint64_t enoughToDraw(const IndexedVolume& volume, const LayersTogether& together,
                      uint64_t array_bytes) {
  const VolumeLayout& layout = volume.source->layout();
  const auto blocks = static_cast<uint64_t>(volume.layout.blockCount());
  // A series has the next step's plan, too.
  const uint64_t plans = (layout.time_steps > 1 ? 2 : 1) * blocks * kPlannedBlockBytes;
  const auto ofLargest = [&](uint64_t bytes) {
    return static_cast<uint64_t>(std::ceil(together.larger * static_cast<double>(bytes)));
  };
  const BufferNeeds needs{
      .block_vox = blockSide(volume.layout, layout.levels),
      .source_thread_bytes = std::max(volume.source->heldBytesAThread(), together.thread_bytes),
      .beside_bytes = ofLargest(array_bytes + plans + spreadBytes(volume)) +
                      leastPictureBytes({.size = {kEnoughSide, kEnoughSide},
                                         .pixel_bytes = std::max(kCpuPixelBytes, kGlPixelBytes)}),
      .numbers = volume.numbers()};
  PageGeometry page = volume.page;
  page.pages = leastPages(page, needs);
  // All of them share the memory evenly.
  return together.count * (std::max(textureMemoryBytes(page, TexelPlace::kInMemory),
                                    textureMemoryBytes(page, TexelPlace::kBorrowed)) +
                           leastBufferBytes(page, needs));
}

BesideShare besideShare(const IndexedVolume& volume, const MachineOptions& machine,
                        Partition partition, const PictureDemand& picture, uint64_t others_bytes) {
  const uint64_t memory_bytes = memoryBudget(machine);
  BesideShare share;
  for (const uint64_t of_memory : {memory_bytes, uint64_t{0}}) {
    share.picture_bytes = pictureBytes(picture, of_memory);
    share.beside_bytes = others_bytes + share.picture_bytes;
    PageGeometry page = volume.page;
    page.pages = pageCount(machine, volume, share.beside_bytes);
    share.pages = page.pages;
    const BufferNeeds needs = needsOf(volume.step(), partition, share.beside_bytes);
    if (textureMemoryBytes(page, TexelPlace::kInMemory) + leastBufferBytes(page, needs) <=
        memory_bytes)
      break;
  }
  return share;
}

uint64_t leastForWholePicture(const IndexedVolume& volume, MachineOptions machine,
                              Partition partition, const PictureDemand& picture,
                              uint64_t others_bytes) {
  const uint64_t beside_bytes = others_bytes + wholePictureBytes(picture);
  machine.memory_bytes = 1;  // for the fewest pages
  PageGeometry page = volume.page;
  page.pages = pageCount(machine, volume, beside_bytes);
  const BufferNeeds needs = needsOf(volume.step(), partition, beside_bytes);
  return std::max(memoryOfWholePicture(picture),
                  textureMemoryBytes(page, TexelPlace::kInMemory) + leastBufferBytes(page, needs));
}

SessionOptions sessionOptions(const IndexedVolume& volume, bool lit, const MachineOptions& machine,
                              Partition partition, uint64_t memory_bytes) {
  SessionOptions options;
  options.page = volume.page;
  options.memory_bytes = memory_bytes;
  options.beside_bytes = volume.rangesBytes();
  options.policy = machine.policy;
  options.seed = machine.seed;
  options.lit = lit;
  options.partition = partition;
  options.index_places = volume.places;
  return options;
}

}  // namespace sluice
