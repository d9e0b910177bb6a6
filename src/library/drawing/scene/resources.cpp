#include "src/library/drawing/scene/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/classify/blocks/classification.h"
#include "src/index/volume_boxes.h"
#include "src/library/drawing/scene/shared_world.h"
#include "src/library/opening/levels/volume_sample.h"
#include "src/render/blocks/look.h"
#include "src/render/blocks/losses/lost_surfaces.h"
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

uint64_t blockBytes(const IndexedVolume& volume) {
  const int64_t side = volume.layout.size;
  return static_cast<uint64_t>(sluice::volume({side, side, side})) * bytesPerVoxel(volume.map.type);
}

// The most blocks that a cut may hold at once, whatever the view.
uint64_t blocksOfCut(const IndexedVolume& volume, const CutOptions& cut) {
  if (cut.level && *cut.level < volume.pyramid->levels())
    return static_cast<uint64_t>(volume.pyramid->level(*cut.level).blocks.blockCount());
  return cut.most_held_bytes / blockBytes(volume) + 1;
}

// The least and the greatest value of a block and of each of its planes.
uint64_t rangeBytesOfBlock(const BlockLayout& layout, DeviceType type) {
  return 2 * bytesPerVoxel(type) * (1 + 3 * static_cast<uint64_t>(layout.planes()));
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
  const uint64_t noted =
      std::min(ranges.unknown.size() * rangeBytesOfBlock(ranges.layout, ranges.map.type),
               LearntRanges::kMostBytes);
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
  const uint64_t block_bytes =
      kPlannedBlockBytes + sizeof(int64_t) + rangeBytesOfBlock(volume.layout, volume.map.type);
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

namespace {

// The most that a source of the volume or of its levels keeps decoded while a thread reads.
uint64_t sourceThreadBytes(const IndexedVolume& volume) {
  uint64_t most = volume.source->heldBytesAThread();
  for (const CoarserLevel& level : coarserLevels(*volume.source)) {
    most = std::max(most, level.source->heldBytesAThread());
    if (level.spreads != nullptr) most = std::max(most, level.spreads->heldBytesAThread());
  }
  return most;
}

// The most that pictures keep of the values of all blocks: the min-max arrays of `array_bytes` with
// those of the step after it (othersBytes()), and what they note.
uint64_t mostRangesBytes(const IndexedVolume& volume, uint64_t array_bytes, bool has_levels,
                         bool is_compared) {
  const auto blocks = static_cast<uint64_t>(volume.layout.blockCount());
  uint64_t bytes = (volume.source->layout().time_steps > 1 ? 3 : 1) * array_bytes;
  // Coarse blocks note their spreads.
  if (has_levels) bytes += std::min(blocks, SpreadTally::kMostBlocks) * SpreadTally::kBlockBytes;
  // The stand-in for the finest level has arrays and the reach of its spreads, too, and pictures
  // learn the ranges of the finest level.
  if (volume.stand_in_level > 0)
    bytes += 2 * array_bytes +
             reachBytes(volume.pyramid->level(volume.stand_in_level).blocks.dims, volume.map.type) +
             3 * (blocks * sizeof(int64_t) +
                  std::min(blocks * rangeBytesOfBlock(volume.layout, volume.map.type),
                           LearntRanges::kMostBytes));
  // Blocks of half the size have about twice as many planes, with borders.
  return is_compared ? bytes + 3 * array_bytes : bytes;
}

}  // namespace

uint64_t enoughToDraw(const IndexedVolume& volume, const IndexPass& pass, bool has_levels,
                      uint64_t array_bytes) {
  const LayersTogether& together = pass.together;
  const ExpectedPictures& pictures = pass.pictures;
  has_levels = has_levels || together.have_levels;
  const auto times = [](double factor, uint64_t bytes) {
    return static_cast<uint64_t>(std::ceil(factor * static_cast<double>(bytes)));
  };
  const uint64_t strip_bytes = leastPictureBytes(
      {.size = {kEnoughSide, kEnoughSide}, .pixel_bytes = std::max(kCpuPixelBytes, kGlPixelBytes)});
  uint64_t beside_bytes = times(together.larger, mostRangesBytes(volume, array_bytes, has_levels,
                                                                 pictures.is_compared)) +
                          std::max(strip_bytes, pictures.picture_bytes) + pictures.light_bytes;
  if (pictures.judges_surfaces && has_levels)
    beside_bytes += static_cast<uint64_t>(pass.pool.threads()) * judgingBytes(volume.layout.size);
  BufferNeeds needs{
      .block_vox = blockSide(volume.layout, has_levels ? 2 : 1),
      .source_thread_bytes = std::max(sourceThreadBytes(volume), together.thread_bytes),
      .numbers = has_levels ? 2 : 1};
  if (pictures.is_compared)
    needs.block_vox = std::max(needs.block_vox, comparedBlock(volume.layout.size));
  if (pictures.grows_boxes)
    needs.growing_bytes = growingBytes(volume.source->layout(), volume.layout);
  PageGeometry page = volume.page;
  page.pages = std::max(leastPages(page, needs), pictures.pages);
  uint64_t of_one =
      times(together.wider, std::max(textureMemoryBytes(page, TexelPlace::kInMemory),
                                     textureMemoryBytes(page, TexelPlace::kBorrowed)) +
                                leastBufferBytes(page, needs)) +
      beside_bytes;
  // A series has the next step's plan, too. A picture of several levels plans no more blocks than
  // half of the memory holds: this share of it.
  uint64_t plans = (volume.source->layout().time_steps > 1 ? 2 : 1) * kPlannedBlockBytes *
                   static_cast<uint64_t>(volume.layout.blockCount());
  const double share = kPlannedBlockBytes / (2.0 * static_cast<double>(blockBytes(volume)));
  if (volume.stand_in_level > 0 && share < 0.5) plans = std::min(plans, times(2 * share, of_one));
  of_one += times(together.larger, plans);
  // All of them share the memory evenly, and a sample grows with it.
  const uint64_t enough = together.count * of_one;
  return volume.sample ? enough + enough / (kSampleMemoryShare - 1) : enough;
}

uint64_t comparingBytes(const IndexedVolume& volume) {
  const BlockLayout& own = volume.layout;
  const BlockLayout other =
      blockLayout(own.dims, comparedBlock(own.size), std::min(own.ghost, 1), volume.name.c_str());
  const SliceRanges& ranges = volume.index->ranges;
  const uint64_t held = ranges.blocks.size() + ranges.unknown.size();
  const uint64_t arrays = held * (other.size < own.size ? 8 : 1) *
                          (sizeof(int64_t) + rangeBytesOfBlock(other, ranges.map.type));
  const auto bufferBytes = [&](int64_t side) {
    BufferNeeds needs = needsOf(volume.step(), Partition::kBlocks, 0);
    needs.block_vox = side;
    PageGeometry page = volume.page;
    page.pages = leastPages(page, needs);
    return textureMemoryBytes(page, TexelPlace::kInMemory) + leastBufferBytes(page, needs);
  };
  return arrays + bufferBytes(std::max(own.size, other.size)) - bufferBytes(own.size);
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
