#include "src/library/drawing/picture_cost.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/threads/threads.h"
#include "src/base/values/volume_levels.h"
#include "src/library/drawing/picture_memory.h"
#include "src/library/drawing/resources.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/session/budgets.h"
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

// The memory in which decoded chunks stay, as a session shares it out on the CPU: without those
// that its threads decode and copy just now, which have no fixed order.
uint64_t heldChunkBytes(const VolumeSource& source, const PageGeometry& page,
                        const BufferNeeds& needs, const MachineOptions& machine) {
  const int threads = machine.threads > 0 ? machine.threads : processorCount();
  try {
    const Budgets budgets = shareMemory(memoryBudget(machine), page, TexelPlace::kBorrowed, needs,
                                        readsAtOnce(source, threads));
    // A thread has three chunks under way, one of which stays afterwards.
    const uint64_t under_way =
        static_cast<uint64_t>(budgets.readers + 1) * needs.source_thread_bytes / 3 * 2;
    return budgets.source - std::min(budgets.source, under_way);
  } catch (const Error&) {  // the picture does not fit, which the forecast tells
    return 0;
  }
}

// The boxes that the frame reads, in the order of the blocks' numbers, which is that of the visit
// or its reverse.
std::vector<LevelBox> boxesOf(const IndexedVolume& volume, const VisibleBlocks& shown) {
  const TimeStep step = volume.step();
  const PyramidLayout layout = step.layout();
  std::vector<LevelBox> boxes;
  for (const ObjectBlock& block : shown.blocks) {
    const Box3 voxels = layout.storedVoxels(block.name);
    if (block.name.level == 0) {
      boxes.push_back({nullptr, voxels});
      continue;
    }
    const CoarserStep& level = step.coarser[static_cast<size_t>(block.name.level) - 1];
    boxes.push_back({level.source, voxels});
    if (level.spreads != nullptr) boxes.push_back({level.spreads, voxels});
  }
  return boxes;
}

}  // namespace

std::optional<StoredReads> storedReadsOfLevel(VolumeSource& source, int64_t time, int level) {
  std::vector<LevelBox> boxes;
  const auto add = [&](const VolumeSource* of, Vec3i dims) { boxes.push_back({of, boxOf(dims)}); };
  if (level == 0) {
    add(nullptr, source.layout().dims);
  } else {
    const CoarserLevel& coarser = coarserLevels(source)[static_cast<size_t>(level) - 1];
    add(coarser.source, coarser.source->layout().dims);
    if (coarser.spreads != nullptr) add(coarser.spreads, coarser.spreads->layout().dims);
  }
  return storedReads(source, time, boxes, UINT64_MAX);
}

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
  BufferNeeds of_session = needs;
  of_session.beside_bytes = share.beside_bytes;
  forecast.stored = storedReads(*volume.source, volume.time, boxesOf(volume, shown),
                                heldChunkBytes(*volume.source, page, of_session, machine));
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
