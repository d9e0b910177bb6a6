#include "src/library/drawing/picture_cost.h"

#include <algorithm>
#include <memory>

#include "src/base/threads/clock.h"
#include "src/library/drawing/picture_memory.h"
#include "src/library/drawing/resources.h"
#include "src/render/camera/frame_setup.h"
#include "src/texture/frame_trace.h"

namespace sluice {
namespace {

// Software GL with its threads, shaders and libraries, OpenVDB's too: measured 60 to 120 MB.
constexpr uint64_t kProgramBytes = uint64_t{120} << 20;

AlgorithmCost costOf(const IndexedVolume& volume, const PlannedBlocks& planned, FrameOptions frame,
                     const PageGeometry& page, Algorithm algorithm, WorkerPool& pool) {
  ChunkNames names;
  Planner planner(page, pool, names);
  frame.algorithm = algorithm;
  Stopwatch watch;
  const FramePlanPtr plan = planner.plan(planned.step, planned.blocks, frame);
  const double seconds = watch.lap();
  const TexturePlan& textures = plan->textures;
  return {textures.chunks.size(),
          textures.clusters.size(),
          textures.cluster_blocks,
          plan->pages,
          bindCount(textures, eyePosition(planned.view, volume.source->layout())),
          textures.bytes(),
          seconds};
}

}  // namespace

PlannedBlocks plannedBlocks(const IndexedVolume& volume, const TimeStep& step,
                            const TransferFunction& transfer, const FrameOptions& frame,
                            const PageGeometry& page, BlockChooser* chooser, WorkerPool& pool) {
  ChunkNames names;
  Planner planner(page, pool, names);
  planner.chooseBlocksBy(chooser);
  PlannedBlocks planned{.step = step, .look = {}, .blocks = {}, .view = {}};
  planned.view = resolve(frame.camera, volume.source->layout(), frame.size, frame.step_vox);
  Stopwatch watch;
  planned.look = planner.look(step, std::make_shared<const TransferFunction>(transfer), frame.mode);
  planned.blocks = planner.visibleBlocks(step, planned.look, planned.view, frame);
  planned.seconds = watch.lap();
  return planned;
}

AlgorithmCosts algorithmCosts(const IndexedVolume& volume, const PlannedBlocks& planned,
                              const FrameOptions& frame, const PageGeometry& page,
                              WorkerPool& pool) {
  // The one asked for first, since merging takes longest.
  std::array<Algorithm, kAlgorithms.size()> order = kAlgorithms;
  std::partition(order.begin(), order.end(),
                 [&](Algorithm algorithm) { return algorithm == frame.algorithm; });
  AlgorithmCosts costs;
  pool.parallelFor(order.size(), [&](int64_t i) {
    const Algorithm algorithm = order[static_cast<size_t>(i)];
    costs[static_cast<size_t>(algorithm)] = costOf(volume, planned, frame, page, algorithm, pool);
  });
  return costs;
}

Forecast forecastOf(const IndexedVolume& volume, const VisibleBlocks& shown,
                    const PageGeometry& page, uint64_t plan_bytes, uint64_t others_bytes,
                    const FrameOptions& frame, const MachineOptions& machine) {
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
  const PictureDemand picture = pictureDemand(machine, frame);
  const BesideShare share = besideShare(volume, machine, frame.partition, picture, others_bytes);
  BufferNeeds needs = bufferNeeds(*volume.source, volume.layout, frame.partition,
                                  others_bytes + leastPictureBytes(picture));
  needs.numbers = volume.numbers();
  const uint64_t textures = textureMemoryBytes(page, TexelPlace::kInMemory);
  forecast.budget_bytes = memoryBudget(machine);
  forecast.least_bytes = textures + leastBufferBytes(page, needs);
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

}  // namespace sluice
