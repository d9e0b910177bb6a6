#include "src/library/drawing/scene/picture_facts.h"

#include <algorithm>
#include <cmath>

#include "src/library/opening/channel_looks.h"
#include "src/library/opening/thick_source.h"

namespace sluice {

namespace {

bool hasColorOfAllLabels(const LookArguments& look) {
  return !look.label_table.empty() ||
         std::ranges::any_of(look.label_looks, [](const LabelLook& label) {
           return std::isinf(label.first) && std::isinf(label.last) && !label.color.empty();
         });
}

// Parts of a look that the looks of single channels replace. A volume over another one has its own.
void addReplaced(const LookArguments& look, const std::vector<LayerLook>& layers,
                 PictureFacts& facts) {
  std::vector<LookArguments> own;
  facts.has_label_colors = true;
  for (const LayerLook& layer : layers) {
    if (layer.volume->channel.is_over) continue;
    own.push_back(lookOfChannel(look, layer.volume->channel));
    facts.has_label_colors &= layer.transfer->labels && hasColorOfAllLabels(own.back());
  }
  const auto isReplaced = [&](const auto& part) {
    return std::ranges::none_of(
        own, [&](const LookArguments& each) { return each.*part == look.*part; });
  };
  facts.map_is_replaced = isReplaced(&LookArguments::map);
  facts.range_is_replaced = isReplaced(&LookArguments::range);
  facts.opacity_is_replaced = isReplaced(&LookArguments::opacity);
  facts.opacities_are_replaced = std::ranges::all_of(own, &LookArguments::labels) && !look.labels;
}

}  // namespace

PictureFacts pictureFacts(const LookArguments& look, const FrameOptions& frame,
                          const MachineOptions& machine, const std::vector<LayerLook>& layers) {
  const ModeTraits& traits = traitsOf(frame.mode);
  PictureFacts facts;
  facts.is_attenuated = traits.combining == Combining::kAttenuated;
  facts.has_colors = traits.has_colors;
  facts.hides = traits.hides;
  facts.is_perspective = frame.camera.projection != Projection::kOrtho;
  facts.step_counts = stepCounts(frame.mode, frame.step_vox);
  facts.asks_to_blend = look.combine == Combine::kBlend;
  facts.merges = frame.algorithm == Algorithm::kMerged;
  facts.is_random = machine.policy == PolicyKind::kRandom;
  facts.is_cut = frame.cut.has_value();
  facts.asks_to_integrate = frame.integrates;
  facts.has_surfaces = !look.surfaces.empty();
  facts.shows_labels = layers.front().transfer->labels;
  addReplaced(look, layers, facts);
  facts.layers = layers.size();
  facts.is_blended = blends(combineOf(look, frame, layers), layers.size());
  facts.integrates = !facts.is_blended && integratesSamples(frame, layers.front());
  facts.has_long_steps = !hasIntegratedSteps(frame, *layers.front().volume);
  facts.time_steps = storedLayout(*layers.front().volume->source).time_steps;
  facts.levels = 1;
  for (const LayerLook& layer : layers)
    facts.levels = std::max(facts.levels, layer.volume->step().coarser.size() + 1);
  return facts;
}

PictureFacts pictureFacts(const Scene& scene, const FrameOptions& frame) {
  PictureFacts facts = pictureFacts(scene.asked, frame, scene.machine, scene.looks());
  facts.is_lit = std::ranges::any_of(scene.layers(), [](const Layer* of) { return of->look.lit; });
  return facts;
}

}  // namespace sluice
