#include "src/options/idle_options.h"

#include <fmt/format.h>

#include <string_view>

namespace sluice {
namespace {

using Facts = PictureFacts;

bool hasNoColors(const Facts& facts) {
  return !facts.has_colors;
}
bool isPlain(const Facts& facts) {
  return facts.asks_to_integrate && !facts.integrates;
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
       [](const Facts& f) { return !f.is_attenuated; },
       "without --mode attenuated-mip"},
      {{"--fov"},
       [](const Facts& f) { return !f.is_perspective; },
       "with an orthographic camera; --projection perspective has a field of view"},
      {{"--combine"},
       [](const Facts& f) { return f.asks_to_blend && f.layers == 1; },
       "in a picture of one channel"},
      {{"--merge"},
       [](const Facts& f) { return !f.merges; },
       "with an --algorithm that does not merge"},
      {{"--rate"},
       [](const Facts& f) { return !f.is_film; },
       "without a film; -o NAME.mp4 makes one"},
      {{"--difference", "--directions", "--part", "--detail", "--basis"},
       [](const Facts& f) { return !f.is_culled; },
       "without --culling"},
      {{"--difference"},
       [](const Facts& f) { return f.time_steps == 1; },
       "for a volume of one time step"},
      {{"--pixel-error", "--max-bytes", "--keep-thin"},
       [](const Facts& f) { return !f.is_cut || f.levels == 1; },
       "in a picture from level 0 alone"},
      {{"--time-limit"},
       [](const Facts& f) { return !f.is_drawn && f.levels == 1; },
       "in the plan of a picture from level 0 alone"},
      {{"--opacity-threshold"},
       [](const Facts& f) { return !f.hides; },
       "in this --mode, where nothing hides what is behind it"},
      {{"--modulate", "--full-gradient"}, hasNoColors, "in this --mode, which shows no opacities"},
      {{"--shade"}, hasNoColors, "in this --mode, which is not lit"},
      {{"--step"},
       [](const Facts& f) { return !f.step_counts; },
       "in this --mode, which takes the voxels' own values, unless it is below 1"},
      {{"--range"},
       [](const Facts& f) { return f.shows_labels && f.has_colors && f.layers == 1; },
       "in a picture of labels"},
      {{"--map"},
       [](const Facts& f) { return f.has_label_colors; },
       "where a table of labels, or --label all, gives the colours"},
      {{"--map"},
       [](const Facts& f) { return f.map_is_replaced; },
       "beside --look, which gives the colours"},
      {{"--range"},
       [](const Facts& f) { return f.range_is_replaced; },
       "beside --look, which gives the range of values"},
      {{"--opacity"},
       [](const Facts& f) { return f.opacity_is_replaced; },
       "beside --look, which gives the opacity"},
      {{"--threshold", "--opacities", "--transfer"},
       [](const Facts& f) { return f.opacities_are_replaced; },
       "beside --look, which draws labels"},
      {{"--seed"}, [](const Facts& f) { return !f.is_random; }, "without --policy random"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && hasNoColors(f); },
       "in this --mode"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && f.has_surfaces; },
       "in a picture with --iso"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && f.shows_labels; },
       "in a picture of labels"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && f.is_blended; },
       "in a blended picture; --combine add does not blend"},
      {{"--quality"},
       [](const Facts& f) { return isPlain(f) && f.has_long_steps; },
       "with a --step of more than 2 voxels along an axis"},
      {{"--quality"}, isPlain, "in a picture from levels of resolution; --level 0 leaves them out"},
      {{"--light", "--ambient", "--diffuse", "--specular", "--shadows", "--occlusion-light"},
       [](const Facts& f) { return hasNoColors(f) || !f.is_lit; },
       "in a picture without lighting; --shade in composite mode lights it"},
  };
  return table;
}

}  // namespace

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
