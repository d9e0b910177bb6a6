#include "src/base/field_names.h"

#include <algorithm>
#include <array>

namespace sluice {
namespace {

struct Rewording {
  std::string_view option, field;
};

// Alternatives that a program with these headers does not have. They come first.
constexpr std::array kPhrases = std::to_array<Rewording>({
    {" with --gl auto", ""},
    {" or a smaller --size", " or a smaller picture"},
    {"; give --device cpu", "; let the CPU draw (device)"},
});

constexpr std::array kFields = std::to_array<Rewording>({
    {"--algorithm", "pipeline.algorithm"},
    {"--ambient", "lighting.ambient"},
    {"--attenuation", "attenuation"},
    {"--azimuth", "view.azimuth_deg"},
    {"--block", "block"},
    {"--cache", "web.cache_bytes"},
    {"--cache-dir", "web.cache_folder"},
    {"--channel", "channel"},
    {"--over", "over"},
    {"--combine", "combine"},
    {"--clip", "clip_planes"},
    {"--crop", "crop"},
    {"--device", "device"},
    {"--diffuse", "lighting.diffuse"},
    {"--dims", "dims"},
    {"--elevation", "view.elevation_deg"},
    {"--endian", "big_endian"},
    {"--eye", "view.look_at.eye"},
    {"--fit", "view.fit"},
    {"--fov", "view.field_of_view_deg"},
    {"--full-gradient", "full_gradient"},
    {"--gl", "pipeline.gl"},
    {"--grid", "grid"},
    {"--index-dir", "index_folder"},
    {"--iso", "surfaces"},
    {"--keep-thin", "keep_thin"},
    {"--label", "label_looks"},
    {"--labels", "labels"},
    {"--labels-table", "label_table"},
    {"--level", "level"},
    {"--levels", "levels"},
    {"--light", "lighting.key"},
    {"--look", "channels"},
    {"--map", "map"},
    {"--max-bytes", "max_bytes"},
    {"--memory", "memory_bytes"},
    {"--merge", "pipeline.merge"},
    {"--mode", "mode"},
    {"--modulate", "full_gradient"},
    {"--no-shade", "light"},
    {"--occlusion", "pipeline.occlusion"},
    {"--occlusion-light", "lighting.occlusion"},
    {"--depth-cueing", "lighting.depth_cueing"},
    {"--opacities", "opacities"},
    {"--opacity", "opacity"},
    {"--opacity-threshold", "opacity_threshold"},
    {"--page", "page"},
    {"--pages", "pipeline.pages"},
    {"--partition", "pipeline.partition"},
    {"--pixel-error", "pixel_error"},
    {"--policy", "pipeline.policy"},
    {"--projection", "view.projection"},
    {"--quality", "quality"},
    {"--jitter", "jitter"},
    {"--range", "range"},
    {"--seed", "pipeline.seed"},
    {"--shade", "light"},
    {"--shadows", "lighting.shadows"},
    {"--simd", "pipeline.simd"},
    {"--size", "width and height"},
    {"--skip", "skip_bytes"},
    {"--spacing", "spacing"},
    {"--specular", "lighting.specular"},
    {"--step", "step_vox"},
    {"--target", "view.look_at.target"},
    {"--this-step", "whole_series"},
    {"--threads", "threads"},
    {"--threshold", "threshold"},
    {"--time", "time"},
    {"--time-limit", "time_limit_s"},
    {"--time-steps", "time_steps"},
    {"--transfer", "transfer_file"},
    {"--type", "type"},
    {"--up", "view.up"},
    {"--view", "view.from"},
    {"--zoom", "view.zoom"},
});

bool isOfWord(char c) {
  return (c >= 'a' && c <= 'z') || c == '-';
}

// Options stand at the beginning, after a space or after a bracket; "--" within a file's name is
// left alone.
bool beginsOption(std::string_view line, size_t at) {
  constexpr std::string_view kBefore = " (";
  return line.substr(at).starts_with("--") &&
         (at == 0 || kBefore.find(line[at - 1]) < kBefore.size());
}

}  // namespace

std::string renamed(std::string_view line,
                    const std::function<std::string(std::string_view option)>& nameOf) {
  std::string given(line);
  for (const Rewording& phrase : kPhrases)
    for (size_t at = 0; (at = given.find(phrase.option, at)) != std::string::npos;
         at += phrase.field.size())
      given.replace(at, phrase.option.size(), phrase.field);

  std::string result;
  for (size_t at = 0; at < given.size();) {
    if (!beginsOption(given, at)) {
      result += given[at++];
      continue;
    }
    const auto begin = given.begin() + static_cast<std::ptrdiff_t>(at);
    const std::string option(begin, std::find_if_not(begin, given.end(), isOfWord));
    result += nameOf(option);
    at += option.size();
  }
  return result;
}

std::string inFields(std::string_view line) {
  return renamed(line, [](std::string_view option) {
    const auto* field = std::ranges::find(kFields, option, &Rewording::option);
    return std::string(field == kFields.end() ? option : field->field);
  });
}

std::string lineInOptions(const std::exception& error) {
  const auto* field_error = dynamic_cast<const FieldError*>(&error);
  return field_error != nullptr ? field_error->lineInOptions() : error.what();
}

}  // namespace sluice
