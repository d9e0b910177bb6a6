#include "src/library/drawing/cost/picture_cost.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "src/base/error.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/threads/clock.h"
#include "src/base/threads/threads.h"
#include "src/library/drawing/cost/picture_memory.h"
#include "src/library/drawing/scene/resources.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/session/budgets.h"
#include "src/render/session/union_plan.h"

namespace sluice {
namespace {

// Software GL with its threads, shaders and libraries, OpenVDB's too: measured 60 to 120 MB.
constexpr uint64_t kProgramBytes = uint64_t{120} << 20;

PlanOptions planOptions(const PlannedBlocks& planned, const FrameOptions& frame,
                        Algorithm algorithm) {
  return {algorithm, frame.merge_order, planned.step.time,
          cropCells(frame, planned.step.ranges->layout.dims)};
}

// The part without its blocks.
PlannedBlocks withLook(const PlannedPart& part, Planner& planner) {
  const FrameOptions& frame = part.frame;
  PlannedBlocks planned{.step = part.step, .look = {}, .blocks = {}, .view = {}};
  planned.view = resolve(frame, part.volume.source->layout());
  planned.look =
      planner.look(part.step, std::make_shared<const TransferFunction>(part.transfer), frame.mode);
  return planned;
}

AlgorithmCost costOf(const IndexedVolume& volume, const PlannedBlocks& planned, FrameOptions frame,
                     const PageGeometry& page, Algorithm algorithm, WorkerPool& pool) {
  AlgorithmCost cost;
  Stopwatch watch;
  const VolumeLayout& layout = volume.source->layout();
  const StripTally strips(viewSetup(planned.view, layout, {}), planned.strips);
  // A plan of every block of a large volume takes more memory than the picture, so its totals are
  // taken in closed form.
  if (loadsEveryBlock(*planned.blocks, algorithm)) {
    const PlanOptions options = planOptions(planned, frame, algorithm);
    static_cast<PlanTotals&>(cost) =
        totalsOfEveryBlock(planned.step.layout(), *planned.blocks, page, options);
    cost.seconds = watch.lap();
    cost.wanted = wantedReadsOfEachBlock(planned.step.layout(), *planned.blocks, options,
                                         layout.type, strips);
    return cost;
  }
  ChunkNames names;
  Planner planner(page, pool, names);
  frame.algorithm = algorithm;
  const FramePlanPtr plan = planner.plan(planned.step, planned.blocks, frame, planned.clusters);
  cost.seconds = watch.lap();
  static_cast<PlanTotals&>(cost) = totalsOf(plan->textures, eyePosition(planned.view, layout));
  cost.wanted = wantedReads(plan->textures, layout.type, strips);
  return cost;
}

// The budgets of the session that draws; nullopt: the picture does not fit.
std::optional<Budgets> budgetsOf(const ForecastInputs& inputs, const BufferNeeds& needs) {
  const MachineOptions& machine = inputs.machine;
  const int threads = machine.threads > 0 ? machine.threads : processorCount();
  try {
    return shareMemory(memoryBudget(machine), inputs.page, inputs.texels, needs,
                       readsAtOnce(*inputs.volume.source, threads));
  } catch (const Error&) {
    return std::nullopt;
  }
}

// The memory in which decoded chunks stay: without those that the threads decode and copy just now,
// which have no fixed order.
uint64_t heldChunkBytes(const std::optional<Budgets>& budgets, const BufferNeeds& needs) {
  if (!budgets) return 0;
  // A thread has three chunks under way, one of which stays afterwards.
  const uint64_t under_way =
      static_cast<uint64_t>(budgets->readers + 1) * needs.source_thread_bytes / 3 * 2;
  return budgets->source - std::min(budgets->source, under_way);
}

// The reads of the blocks that the algorithm loads. The boxes in a store of chunks are in the order
// of the blocks' numbers, which is that of the visit or its reverse.
void addReads(const ForecastInputs& inputs, uint64_t held_chunk_bytes, Forecast& forecast) {
  const PlannedBlocks& planned = inputs.planned;
  VolumeSource& source = *inputs.volume.source;
  const TimeStep step = inputs.volume.step();
  const PyramidLayout layout = step.layout();
  const VoxelType type = source.layout().type;
  // Only a store of chunks can tell ahead which stored bytes a box takes.
  const bool is_store = dynamic_cast<StoredSource*>(&source) != nullptr;
  std::vector<LevelBox> boxes;
  const auto add = [&](const TextureBlock& block) {
    if (block.isOfSeam()) return;  // its voxels are those of a block that counts
    const BlockName& name = block.name;
    ++forecast.blocks;
    forecast.voxel_bytes += decodedBytes(layout, type, name);
    if (!is_store) return;
    const Box3 voxels = layout.storedVoxels(name);
    if (name.level == 0) {
      boxes.push_back({nullptr, voxels});
      return;
    }
    const CoarserStep& level = step.coarser[static_cast<size_t>(name.level) - 1];
    boxes.push_back({level.source, voxels});
    // A coarse voxel stands for a distribution: its spread lies in an array of its own, which is
    // read as well.
    if (level.spreads != nullptr) boxes.push_back({level.spreads, voxels});
  };
  visitTextureBlocks(layout, *planned.blocks,
                     planOptions(planned, inputs.frame, inputs.frame.algorithm), add);
  if (is_store) forecast.stored = storedReads(source, inputs.volume.time, boxes, held_chunk_bytes);
}

// Blocks are read once if level 2 holds them all, and as often as they are wanted otherwise.
void addMostReads(const WantedReads& wanted, const std::optional<Budgets>& budgets,
                  Forecast& forecast) {
  const bool holds_all = budgets && budgets->volume_buffer >= forecast.voxel_bytes;
  forecast.most_blocks = forecast.blocks;
  forecast.most_voxel_bytes = forecast.voxel_bytes;
  if (holds_all) return;
  forecast.most_blocks = std::max(forecast.most_blocks, wanted.blocks);
  forecast.most_voxel_bytes = std::max(forecast.most_voxel_bytes, wanted.voxel_bytes);
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
  // A pass reads each chunk once, so the memory for decoded chunks does not matter.
  return storedReads(source, time, boxes, UINT64_MAX);
}

PlannedBlocks plannedBlocks(const PlannedPart& part, BlockChooser* chooser, WorkerPool& pool) {
  ChunkNames names;
  Planner planner(part.page, pool, names);
  planner.chooseBlocksBy(chooser);
  Stopwatch watch;
  PlannedBlocks planned = withLook(part, planner);
  planned.blocks = planner.visibleBlocks(
      Planner::question(planned.step, planned.look, planned.view, part.frame));
  planned.seconds = watch.lap();
  return planned;
}

std::vector<PictureRows> plannedStrips(const IndexedVolume& volume, const MachineOptions& machine,
                                       const FrameOptions& frame, uint64_t others_bytes) {
  const PictureDemand picture = pictureDemand(machine, frame);
  return stripsOf(
      picture, besideShare(volume, machine, frame.partition, picture, others_bytes).picture_bytes);
}

std::vector<PlannedBlocks> plannedTogether(std::span<const PlannedPart> parts, WorkerPool& pool) {
  Stopwatch watch;
  ChunkNames names;  // no chunk gets one
  std::vector<std::unique_ptr<Planner>> planners;
  std::vector<Planner*> asked;
  std::vector<BlockQuestion> questions;
  std::vector<PlannedBlocks> planned;
  for (const PlannedPart& part : parts) {
    asked.push_back(planners.emplace_back(std::make_unique<Planner>(part.page, pool, names)).get());
    planned.push_back(withLook(part, *asked.back()));
    questions.push_back(
        Planner::question(part.step, planned.back().look, planned.back().view, part.frame));
  }
  const std::vector<VisibleBlocksPtr> visible = Planner::visibleTogether(asked, questions);
  std::vector<ChannelBlocks> blocks;
  for (size_t i = 0; i < parts.size(); ++i) {
    planned[i].blocks = visible[i];
    blocks.push_back({parts[i].step.layout(), visible[i], parts[i].page});
  }
  planned.front().seconds = watch.lap();
  const PlannedPart& first = parts.front();
  // Blended channels are drawn block by block together, so that one plan of the union of their
  // blocks orders the clusters of all.
  const auto clusters = std::make_shared<const TexturePlan>(
      unionPlan(blocks, planOptions(planned.front(), first.frame, Algorithm::kTrimmed)));
  for (PlannedBlocks& each : planned) each.clusters = clusters;
  return planned;
}

AlgorithmCosts algorithmCosts(const IndexedVolume& volume, const PlannedBlocks& planned,
                              const FrameOptions& frame, const PageGeometry& page,
                              WorkerPool& pool) {
  // One after the other, since all plans at once would take several times the memory of one.
  AlgorithmCosts costs;
  for (const Algorithm algorithm : kAlgorithms)
    costs[static_cast<size_t>(algorithm)] = costOf(volume, planned, frame, page, algorithm, pool);
  return costs;
}

void requireRoomToPlan(const IndexedVolume& volume, const PageGeometry& page, uint64_t others_bytes,
                       const FrameOptions& frame, const MachineOptions& machine,
                       TexelPlace texels) {
  if (others_bytes <= memoryBudget(machine)) return;
  const BesideShare share =
      besideShare(volume, machine, frame.partition, pictureDemand(machine, frame), others_bytes);
  // Throws with the memory that is needed: the plan alone exceeds the budget, so no sharing can
  // fit.
  shareMemory(memoryBudget(machine), page, texels,
              needsOf(volume.step(), frame.partition, share.beside_bytes), 1);
}

Forecast forecastOf(const ForecastInputs& inputs) {
  const auto& [volume, planned, page, cost, others_bytes, frame, machine, texels] = inputs;
  Forecast forecast;
  forecast.index_bytes = volume.rangesBytes();
  const PictureDemand picture = pictureDemand(machine, frame);
  const BesideShare share = besideShare(volume, machine, frame.partition, picture, others_bytes);
  const BufferNeeds needs = needsOf(volume.step(), frame.partition, share.beside_bytes);
  const std::optional<Budgets> budgets = budgetsOf(inputs, needs);
  addReads(inputs, heldChunkBytes(budgets, needs), forecast);
  addMostReads(cost.wanted, budgets, forecast);
  // The least is with the picture in strips, which is how it is drawn if nothing else fits.
  const uint64_t textures = textureMemoryBytes(page, texels);
  forecast.budget_bytes = memoryBudget(machine);
  forecast.least_bytes =
      textures + leastBufferBytes(page, needsOf(volume.step(), frame.partition,
                                                others_bytes + leastPictureBytes(picture)));
  forecast.fits_budget = forecast.least_bytes <= forecast.budget_bytes;
  // Blocks once, and chunks twice: filled in memory, and as textures.
  const uint64_t copies = textureMemoryBytes(page, TexelPlace::kInMemory);
  const uint64_t wanted =
      share.beside_bytes + forecast.voxel_bytes + cost.bytes + std::min(cost.bytes, copies);
  forecast.buffer_bytes =
      // The session keeps its buffers within the budget, and never below the least that one cluster
      // takes.
      std::min(forecast.budget_bytes,
               std::max(wanted, forecast.least_bytes - std::min(forecast.least_bytes, textures)));
  forecast.picture_bytes = share.picture_bytes;
  forecast.program_bytes = kProgramBytes;
  forecast.machine_bytes = availableMemoryBytes();
  return forecast;
}

}  // namespace sluice
