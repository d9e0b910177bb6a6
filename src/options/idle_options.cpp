#include "tools/options/idle_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>

#include "src/library/opening/thick_source.h"

namespace sluice {
namespace {

using Facts = PictureFacts;

const ModeTraits& traits(const Facts& facts) {
  return traitsOf(facts.frame.mode);
}
bool hasNoColors(const Facts& facts) {
  return !traits(facts).has_colors;
}
bool isPlain(const Facts& facts) {
  return facts.frame.integrates && !facts.integrates;
}

// A reason for which options are idle. The first rule that holds is the one that is printed.
struct IdleRule {
  std::vector<std::string_view> options;
  bool (*holds)(const Facts& facts);
  std::string_view why;  // behind "changes nothing"
};

const std::vector<IdleRule>& rules() {
  static const std::vector<IdleRule> table{
      {{"--attenuation"},
       [](const Facts& f) { return traits(f).combining != Combining::kAttenuated; },
       "without --mode attenuated-mip"},
      {{"--fov"},
       [](const Facts& f) { return f.frame.camera.projection == Projection::kOrtho; },
       "with an orthographic camera; --projection perspective has a field of view"},
      {{"--combine"},
       [](const Facts& f) { return f.look.combine == Combine::kBlend && f.layers == 1; },
       "in a picture of one channel"},
      {{"--merge"},
       [](const Facts& f) { return f.frame.algorithm != Algorithm::kMerged; },
       "with an --algorithm that does not merge"},
      {{"--rate"},
       [](const Facts& f) { return !f.is_film; },
       "without a film; -o NAME.mp4 makes one"},
      {{"--difference", "--directions", "--part", "--detail", "--basis"},
       [](const Facts& f) { return f.culling.culling == Culling::kNone; },
       "without --culling"},
      {{"--difference"},
       [](const Facts& f) { return f.time_steps == 1; },
       "for a volume of one time step"},
      {{"--pixel-error", "--max-bytes", "--keep-thin"},
       [](const Facts& f) { return !f.frame.cut || f.levels == 1; },
       "in a picture from level 0 alone"},
      {{"--time-limit"},
       [](const Facts& f) { return !f.is_drawn && f.levels == 1; },
       "in the plan of a picture from level 0 alone"},
      {{"--opacity-threshold"},
       [](const Facts& f) { return !traits(f).hides; },
       "in this --mode, where nothing hides what is behind it"},
      {{"--modulate", "--full-gradient"}, hasNoColors, "in this --mode, which shows no opacities"},
      {{"--shade"}, hasNoColors, "in this --mode, which is not lit"},
      {{"--step"},
       [](const Facts& f) { return !stepCounts(f.frame.mode, f.frame.step_vox); },
       "in this --mode, which takes the voxels' own values, unless it is below 1"},
      {{"--seed"},
       [](const Facts& f) { return f.machine.policy != PolicyKind::kRandom; },
       "without --policy random"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && hasNoColors(f); },
       "in this --mode"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && !f.look.surfaces.empty(); },
       "in a picture with --iso"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && f.shows_labels; },
       "in a picture of labels"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && f.is_blended; },
       "in a blended picture; --combine add does not blend"},
      {{"--quality"}, isPlain, "in a picture from levels of resolution; --level 0 leaves them out"},
      {{"--light", "--ambient", "--diffuse", "--specular", "--shadows", "--occlusion-light"},
       [](const Facts& f) { return hasNoColors(f) || !f.is_lit; },
       "in a picture without lighting; --shade in composite mode lights it"},
  };
  return table;
}

}  // namespace

std::set<std::string> givenOptions(const CLI::App& app) {
  std::set<std::string> given;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0) given.insert(option->get_name());
  return given;
}

PictureFacts pictureFacts(const LookArguments& look, const FrameOptions& frame,
                          const CullingArguments& culling, const MachineOptions& machine,
                          const std::vector<LayerLook>& layers) {
  PictureFacts facts{look, frame, culling, machine};
  facts.shows_labels = layers.front().transfer->labels;
  facts.layers = layers.size();
  facts.is_blended = blends(combineOf(look, frame, layers), layers.size());
  facts.time_steps = storedLayout(*layers.front().volume->source).time_steps;
  facts.levels = 1;
  for (const LayerLook& layer : layers)
    facts.levels = std::max(facts.levels, layer.volume->step().coarser.size() + 1);
  return facts;
}

std::vector<std::string> idleOptions(const std::set<std::string>& given, const Facts& facts) {
  std::vector<std::string> lines;
  std::set<std::string_view> told;
  for (const IdleRule& rule : rules()) {
    if (!rule.holds(facts)) continue;
    for (const std::string_view option : rule.options)
      if (given.contains(std::string(option)) && told.insert(option).second)
        lines.push_back(fmt::format("{} changes nothing {}", option, rule.why));
  }
  return lines;
}

}  // namespace sluice
