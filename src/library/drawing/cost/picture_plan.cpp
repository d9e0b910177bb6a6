#include "src/library/drawing/cost/picture_plan.h"

#include <string>

#include "src/library/drawing/cost/planned_channels.h"

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

PicturePlan planOf(const PlannedSum& sum, const VisibleBlocks& blocks, Algorithm algorithm) {
  const AlgorithmCost& chosen = sum.costs[static_cast<size_t>(algorithm)];
  PicturePlan plan;
  plan.white = sum.white;
  plan.grey = sum.grey;
  plan.black = sum.black;
  for (size_t i = 0; i < sum.costs.size(); ++i)
    plan.algorithms[i] = {.name = std::string(name(kAlgorithms[i])),
                          .chunks = sum.costs[i].chunks,
                          .pages = static_cast<uint64_t>(sum.costs[i].pages),
                          .bytes = sum.costs[i].bytes,
                          .binds = static_cast<uint64_t>(sum.costs[i].binds)};
  plan.clusters = chosen.clusters;
  plan.read_blocks = sum.forecast.blocks;
  plan.read_voxel_bytes = sum.forecast.voxel_bytes;
  plan.most_read_blocks = sum.forecast.most_blocks;
  plan.most_read_voxel_bytes = sum.forecast.most_voxel_bytes;
  plan.memory = memoryOf(sum.forecast);
  if (blocks.cut) {
    for (const CutSummary::Level& level : blocks.cut->levels)
      plan.levels.push_back({level.level, level.blocks, level.cells});
    plan.coarse_share = blocks.cut->coarse_share;
    plan.is_refined = blocks.cut->is_final;
  }
  plan.classify_seconds = sum.classify_seconds;
  plan.plan_seconds = chosen.seconds;
  return plan;
}

}  // namespace

PicturePlan planOf(const Scene& scene, const std::vector<TimeStep>& steps,
                   const FrameOptions& options) {
  std::vector<ChannelShare> shares;
  const std::vector<const Layer*> layers = scene.layers();
  shares.reserve(layers.size());
  for (size_t i = 0; i < layers.size(); ++i) {
    const Layer& layer = *layers[i];
    const FrameOptions own = scene.optionsOf(layer, options);
    shares.push_back(
        {.look = {&layer.volume, &layer.look.transfer},
         .step = steps[i],
         .frame = own,
         .machine = layer.machine,
         .page = layer.page,
         .others_bytes = othersBytes(layer.volume, layer.look.transfer, own, scene.pool)});
  }
  const std::vector<PlannedChannel> channels =
      plannedChannels(shares, scene.combine, nullptr, scene.device->limits().texels, scene.pool);
  PicturePlan plan = planOf(sumOf(channels), *channels.front().shown.blocks, options.algorithm);
  for (size_t i = 0; channels.size() > 1 && i < channels.size(); ++i) {
    const ShownChannel& shown = layers[i]->volume.channel;
    PicturePlan& own = plan.channels.emplace_back(
        planOf(costOf(channels[i]), *channels[i].shown.blocks, options.algorithm));
    own.channel = shown.id();
    own.name = shown.name;
  }
  return plan;
}

}  // namespace sluice
