#include "src/library/drawing/picture_plan.h"

#include "src/library/drawing/picture_cost.h"

namespace sluice {
namespace {

PicturePlan::Memory memoryOf(const Forecast& forecast) {
  return {.budget_bytes = forecast.budget_bytes,
          .least_bytes = forecast.least_bytes,
          .buffer_bytes = forecast.buffer_bytes,
          .index_bytes = forecast.index_bytes,
          .picture_bytes = forecast.picture_bytes,
          .program_bytes = forecast.program_bytes,
          .peak_bytes = forecast.peakBytes(),
          .machine_bytes = forecast.machine_bytes,
          .fits = forecast.fits()};
}

}  // namespace

PicturePlan planOf(const Scene& scene, const TimeStep& step, const FrameOptions& options) {
  const IndexedVolume& volume = scene.volume;
  const TransferFunction& transfer = scene.look.transfer;
  const PlannedBlocks planned =
      plannedBlocks({volume, step, transfer, options, scene.page}, nullptr, scene.pool);
  const AlgorithmCosts costs = algorithmCosts(volume, planned, options, scene.page, scene.pool);
  const AlgorithmCost& chosen = costs[static_cast<size_t>(options.algorithm)];
  const Forecast forecast = forecastOf({volume, planned, scene.page, chosen,
                                        othersBytes(volume, transfer, options, scene.pool), options,
                                        scene.machine, scene.device->limits().texels});

  PicturePlan plan;
  plan.white = planned.blocks->white;
  plan.grey = planned.blocks->grey;
  plan.black = planned.blocks->black;
  for (size_t i = 0; i < costs.size(); ++i)
    plan.algorithms[i] = {.name = std::string(name(kAlgorithms[i])),
                          .chunks = costs[i].chunks,
                          .pages = static_cast<uint64_t>(costs[i].pages),
                          .bytes = costs[i].bytes,
                          .binds = static_cast<uint64_t>(costs[i].binds)};
  plan.clusters = chosen.clusters;
  plan.read_blocks = forecast.blocks;
  plan.read_voxel_bytes = forecast.voxel_bytes;
  plan.most_read_blocks = forecast.most_blocks;
  plan.most_read_voxel_bytes = forecast.most_voxel_bytes;
  plan.memory = memoryOf(forecast);
  if (planned.blocks->cut) {
    for (const CutSummary::Level& level : planned.blocks->cut->levels)
      plan.levels.push_back({level.level, level.blocks, level.cells});
    plan.coarse_share = planned.blocks->cut->coarse_share;
    plan.is_refined = planned.blocks->cut->is_final;
  }
  plan.classify_seconds = planned.seconds;
  plan.plan_seconds = chosen.seconds;
  return plan;
}

}  // namespace sluice
