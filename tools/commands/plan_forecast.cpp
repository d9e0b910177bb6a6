#include "tools/commands/plan_forecast.h"

#include <algorithm>

#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/picture_memory.h"
#include "src/library/drawing/scene.h"
#include "tools/command_line/console.h"

namespace sluice {
namespace {

// Software GL with its threads, shaders and libraries, OpenVDB's too: measured 60 to 120 MB.
constexpr uint64_t kProgramBytes = uint64_t{120} << 20;

}  // namespace

Forecast forecastOf(const IndexedVolume& volume, const VisibleBlocks& shown, uint64_t plan_bytes,
                    uint64_t others_bytes, const FrameOptions& frame,
                    const ResourceArguments& resources) {
  Forecast forecast;
  forecast.blocks = static_cast<int64_t>(shown.blocks.size());
  const VoxelType type = volume.source->layout().type;
  const PyramidLayout layout = volume.step().layout();
  for (const ObjectBlock& block : shown.blocks) {
    const Box3 voxels = layout.storedVoxels(block.name);
    forecast.voxel_bytes += static_cast<uint64_t>(voxels.count()) *
                            storedBytesPerVoxel(type, layout.of(block.name).numbers);
  }
  forecast.index_bytes = volume.rangesBytes();
  const PictureDemand picture = pictureDemand(resources, frame);
  const BesideShare share = besideShare(volume, resources, frame.partition, picture, others_bytes);
  BufferNeeds needs = bufferNeeds(*volume.source, volume.layout, frame.partition,
                                  others_bytes + leastPictureBytes(picture));
  needs.numbers = volume.numbers();
  const uint64_t textures = textureMemoryBytes(volume.page, TexelPlace::kInMemory);
  forecast.budget_bytes = memoryBudget(resources);
  forecast.least_bytes = textures + leastBufferBytes(volume.page, needs);
  // Blocks once, and chunks twice: filled in memory, and as textures.
  const uint64_t wanted =
      share.beside_bytes + forecast.voxel_bytes + plan_bytes + std::min(plan_bytes, textures);
  forecast.buffer_bytes =
      std::min(forecast.budget_bytes, std::max(wanted, forecast.least_bytes - textures));
  forecast.picture_bytes = share.picture_bytes;
  forecast.program_bytes = kProgramBytes;
  forecast.machine_bytes = availableMemoryBytes();
  return forecast;
}

nlohmann::json readJson(const Forecast& forecast) {
  return {{"blocks", forecast.blocks}, {"voxel_bytes", forecast.voxel_bytes}};
}

nlohmann::json memoryJson(const Forecast& forecast) {
  return {{"budget_bytes", forecast.budget_bytes},
          {"least_bytes", forecast.least_bytes},
          {"buffer_bytes", forecast.buffer_bytes},
          {"index_bytes", forecast.index_bytes},
          {"picture_bytes", forecast.picture_bytes},
          {"program_bytes", forecast.program_bytes},
          {"peak_bytes", forecast.peakBytes()},
          {"machine_bytes", forecast.machine_bytes},
          {"fits", forecast.fits()}};
}

void printForecast(const Forecast& forecast) {
  say("reads {} block{}, {} of voxels; {} of memory at most: {} of --memory {}, {} beside it\n",
      forecast.blocks, forecast.blocks == 1 ? "" : "s", formatBytes(forecast.voxel_bytes),
      formatBytes(forecast.peakBytes()), formatBytes(forecast.buffer_bytes),
      formatBytes(forecast.budget_bytes),
      formatBytes(forecast.peakBytes() - forecast.buffer_bytes));
  if (forecast.least_bytes > forecast.budget_bytes) {
    say("does not fit --memory: {} is the least that works, or fewer --pages\n",
        formatBytes(forecast.least_bytes));
  } else {
    say("{} this machine, which has {}\n", forecast.fits() ? "fits" : "does not fit",
        formatBytes(forecast.machine_bytes));
  }
}

}  // namespace sluice
