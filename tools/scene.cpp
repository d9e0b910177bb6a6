#include "tools/scene.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/classify/transfer_file.h"
#include "src/classify/transfer_makers.h"
#include "src/gl/gl_device.h"
#include "src/render/index_space.h"

namespace sluice {
namespace {

// Textures may take this share of the memory where they live in it; elsewhere their memory is not
// known to the program, and this much is on any GPU of the last ten years.
constexpr uint64_t kTextureShare = 4;
constexpr uint64_t kDeviceTextureBytes = uint64_t{1} << 30;

// How many pages where the user does not say: what holds the volume, or what memory comfortably
// does beside the least buffers, but never fewer than a block takes.
int64_t defaultPages(const PageGeometry& page, const BlockLayout& layout, uint64_t memory_bytes,
                     const VolumeSource& source) {
  const auto page_bytes = static_cast<uint64_t>(page.pageBytes());
  const Vec3i block{layout.size, layout.size, layout.size};
  const auto least = std::bit_ceil(static_cast<uint64_t>(page.pagesOf(block)));
  // Blocks share planes and are padded: twice the volume's own pages holds them all.
  const Vec3i bounded = min(source.layout().dims, Vec3i{1 << 20, 1 << 20, 1 << 20});
  const double whole = std::min(2.0 * static_cast<double>(page.pagesOf(bounded)), 1e15);
  const uint64_t most = std::min(memory_bytes / kTextureShare, kDeviceTextureBytes) / page_bytes;
  uint64_t pages = std::min(std::bit_floor(std::max<uint64_t>(1, most)),
                            std::bit_ceil(static_cast<uint64_t>(whole)));
  pages = std::max(pages, least);
  // The partition makes no difference, so that a plan holds for both.
  const BufferNeeds needs = bufferNeeds(source, layout, Partition::kBlocks);
  const uint64_t buffers = leastBufferBytes(page, needs);
  const auto needed = [&] {
    PageGeometry geometry = page;
    geometry.pages = static_cast<int64_t>(pages);
    return textureMemoryBytes(geometry, true) + buffers;
  };
  while (pages > least && needed() > memory_bytes) pages /= 2;
  return static_cast<int64_t>(pages);
}

// The standard 64 KiB page of the voxel type unless the user says otherwise; pages still open.
PageGeometry pageShape(const ResourceArguments& resources, const ValueMap& map) {
  PageGeometry page;
  page.bytes_per_voxel = static_cast<int64_t>(bytesPerVoxel(map.type));
  const char* standard = page.bytes_per_voxel == 1   ? "sparse-8"
                         : page.bytes_per_voxel == 2 ? "sparse-16"
                                                     : "sparse-32";
  page.size_vox = resources.page_vox.value_or(findPageConfiguration(standard)->geometry.size_vox);
  return page;
}

// Of values, where the ranges count device values.
Histogram valueHistogram(const SliceRanges& ranges) {
  Histogram histogram = ranges.histogram;
  histogram.range = {ranges.map.valueOf(histogram.range.lo),
                     ranges.map.valueOf(histogram.range.hi)};
  if (ranges.map.scale < 0) {
    std::swap(histogram.range.lo, histogram.range.hi);
    std::reverse(histogram.counts.begin(), histogram.counts.end());
  }
  return histogram;
}

TransferFunction automaticFor(const IndexedVolume& volume, const LookArguments& look) {
  const VolumeLayout& layout = volume.source->layout();
  AutomaticOptions options;
  const double finest = finestSpacing(layout);
  options.thickness_vox = 0;
  for (int a = 0; a < 3; ++a)
    options.thickness_vox += static_cast<double>(layout.dims[a]) * layout.spacing[a] / finest / 3;
  options.signed_distance = layout.name.ends_with("(level set)");
  options.finest_spacing = finest;
  options.map = look.map;
  TransferFunction transfer = automaticTransfer(valueHistogram(volume.index.ranges), options);
  return look.opacity ? scaleOpacity(std::move(transfer), *look.opacity / kDefaultOpacity)
                      : transfer;
}

}  // namespace

uint64_t memoryBudget(const ResourceArguments& resources) {
  return resources.memory_bytes != 0 ? resources.memory_bytes : availableMemoryBytes() / 2;
}

ValueRange IndexedVolume::valueRange() const {
  const ValueRange device = index.ranges.device_range;
  const double a = map.valueOf(device.lo), b = map.valueOf(device.hi);
  return {std::min(a, b), std::max(a, b)};
}

IndexedVolume openIndexed(const VolumeArguments& arguments, const ResourceArguments& resources,
                          bool gradients, WorkerPool& pool) {
  IndexedVolume volume;
  volume.source = openVolume(arguments.inputs, arguments.open);
  const VolumeLayout& layout = volume.source->layout();
  const std::string& name = arguments.inputs.front();
  if (arguments.time >= layout.time_steps)
    fail("{}: --time {}: the volume has {} time step{}, counted from 0", name, arguments.time,
         layout.time_steps, layout.time_steps == 1 ? "" : "s");
  volume.map = deviceMap(layout);
  volume.page = pageShape(resources, volume.map);
  const int64_t block = resources.block.value_or(blockSizeFor(volume.page.size_vox));
  volume.layout = blockLayout(layout.dims, block, gradients ? 1 : 0, name.c_str());
  volume.page.pages = resources.pages.value_or(
      defaultPages(volume.page, volume.layout, memoryBudget(resources), *volume.source));
  // The first opening reads everything, and nothing else is in memory then.
  const uint64_t memory_bytes = memoryBudget(resources);
  volume.source->holdAtMost(memory_bytes / 4);
  volume.index = indexedRanges(*volume.source, name, arguments.time, volume.layout, pool,
                               std::min(memory_bytes / 2, kMostIndexingBytes));
  return volume;
}

bool needsGradients(const LookArguments& look) {
  if (look.shade || look.modulate) return true;
  // Whatever the volume's range is.
  return !look.transfer_file.empty() &&
         !readTransferFunction(look.transfer_file, {0, 1}, look.map).gradients.empty();
}

namespace {

TransferFunction plainTransferFor(const IndexedVolume& volume, const LookArguments& look) {
  const ValueRange range = volume.valueRange();
  const double opacity = look.opacity.value_or(kDefaultOpacity);
  if (!look.transfer_file.empty()) return readTransferFunction(look.transfer_file, range, look.map);
  if (look.threshold)
    return thresholdTransfer(*look.threshold, range, opacity,
                             look.map.empty() ? kDefaultColorMap : std::string_view(look.map));
  return automaticFor(volume, look);
}

}  // namespace

TransferFunction transferFor(const IndexedVolume& volume, const LookArguments& look) {
  TransferFunction transfer = plainTransferFor(volume, look);
  if (!look.modulate) return transfer;
  const ValueRange range = volume.valueRange();
  // A volume of one value is flat, whatever the unit.
  const double unit = range.hi > range.lo ? range.hi - range.lo : 1;
  return modulateByGradient(std::move(transfer), look.full_gradient * unit);
}

PlannedFrame planFrame(const IndexedVolume& volume, const TransferFunction& transfer,
                       const FrameOptions& options, int64_t time, WorkerPool& pool) {
  const SliceRanges& ranges = volume.index.ranges;
  Stopwatch watch;
  PlannedFrame result;
  const Box3 crop = cropCells(options, ranges.layout.dims);
  const OpacityTable table(transfer, ranges.map, ranges.device_range);
  const Classification classes = classify(ranges, table, crop, pool);
  result.classify_seconds = watch.lap();
  result.plan = planTextures(ranges.layout, classes, volume.page,
                             {options.algorithm, options.merge_order, time, crop});
  result.plan_seconds = watch.lap();
  return result;
}

SessionOptions sessionOptions(const VolumeArguments& arguments, const PageGeometry& page,
                              const LookArguments& look, const ResourceArguments& resources,
                              Partition partition, uint64_t memory_bytes) {
  SessionOptions options;
  options.page = page;
  options.memory_bytes = memory_bytes;
  options.policy = resources.policy;
  options.seed = resources.seed;
  options.lit = look.shade;
  options.partition = partition;
  options.volume_name = arguments.inputs.front();
  return options;
}

Scene::Scene(const VolumeArguments& arguments, const LookArguments& look,
             const ResourceArguments& resources, Partition partition)
    : pool(resources.threads),
      volume(openIndexed(arguments, resources, needsGradients(look), pool)),
      memory_bytes(memoryBudget(resources)),
      device(std::make_unique<GlDevice>(createContext(resources.gl))),
      transfer(transferFor(volume, look)) {
  session = std::make_unique<Session>(
      *volume.source, arguments.time, volume.index.ranges, *device, pool,
      sessionOptions(arguments, volume.page, look, resources, partition, memory_bytes));
  session->setTransferFunction(transfer);
}

}  // namespace sluice
