#include "src/view/state/printed_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/base/files/shell_word.h"

namespace sluice {
namespace {

template <class List>
std::string listed(const List& values) {
  std::string text;
  for (const auto& value : values) text += fmt::format("{}{}", text.empty() ? "" : ",", value);
  return text;
}

// The words of `sluice render`'s --mode.
const char* name(LookOptions::Mode mode) {
  switch (mode) {
    case LookOptions::Mode::kMaximum:
      return "mip";
    case LookOptions::Mode::kMinimum:
      return "minip";
    case LookOptions::Mode::kAverage:
      return "average";
    case LookOptions::Mode::kComposite:
      break;
  }
  return "composite";
}

const char* name(ViewOptions::From from) {
  switch (from) {
    case ViewOptions::From::kPlain:
      return "plain";
    case ViewOptions::From::kFront:
      return "front";
    case ViewOptions::From::kBack:
      return "back";
    case ViewOptions::From::kLeft:
      return "left";
    case ViewOptions::From::kRight:
      return "right";
    case ViewOptions::From::kTop:
      return "top";
    case ViewOptions::From::kBottom:
      return "bottom";
    case ViewOptions::From::kThreeQuarter:
      break;
  }
  return "three-quarter";
}

void addView(std::vector<OptionWord>& words, const ViewOptions& view) {
  const bool is_perspective = view.projection == ViewOptions::Projection::kPerspective;
  words.emplace_back("--projection", is_perspective ? "perspective" : "ortho");
  if (view.look_at) {
    words.emplace_back("--eye", listed(view.look_at->eye));
    words.emplace_back("--target", listed(view.look_at->target));
  } else {
    words.emplace_back("--view", name(view.from));
    words.emplace_back("--azimuth", fmt::format("{}", view.azimuth_deg));
    words.emplace_back("--elevation", fmt::format("{}", view.elevation_deg));
    if (view.fit)
      words.emplace_back("--fit", *view.fit == ViewOptions::Fit::kVolume ? "volume" : "visible");
  }
  if (view.up) words.emplace_back("--up", listed(*view.up));
  words.emplace_back("--zoom", fmt::format("{}", view.zoom));
  if (is_perspective) words.emplace_back("--fov", fmt::format("{}", view.field_of_view_deg));
}

// A name that begins as options do.
std::string asOperand(const std::string& path) {
  return path.starts_with('-') ? "./" + path : path;
}

}  // namespace

std::vector<OptionWord> volumeWords(const VolumeOptions& options) {
  std::vector<OptionWord> words;
  if (options.dims)
    words.emplace_back("--dims",
                       listed(*options.dims) +
                           (options.time_steps ? fmt::format(",{}", *options.time_steps) : ""));
  if (!options.type.empty()) words.emplace_back("--type", options.type);
  if (options.big_endian) words.emplace_back("--endian", "big");
  if (options.skip_bytes != 0) words.emplace_back("--skip", fmt::format("{}", options.skip_bytes));
  if (options.spacing) words.emplace_back("--spacing", listed(*options.spacing));
  if (!options.grid.empty()) words.emplace_back("--grid", options.grid);
  if (options.channel) words.emplace_back("--channel", fmt::format("{}", *options.channel));
  if (!options.channel && !options.channel_name.empty())
    words.emplace_back("--channel", options.channel_name);
  return words;
}

std::vector<OptionWord> lookWords(const LookOptions& look) {
  std::vector<OptionWord> words;
  if (!look.transfer_file.empty()) words.emplace_back("--transfer", look.transfer_file);
  if (!look.opacities.empty()) {
    std::string points;
    for (const LookOptions::Opacity& point : look.opacities)
      points += fmt::format("{}{}:{}", points.empty() ? "" : ",", point.value, point.opacity);
    words.emplace_back("--opacities", points);
  } else if (!look.transfer_file.empty()) {  // has them
  } else if (look.labels) {
    words.emplace_back("--labels", "");
  } else if (look.threshold) {
    words.emplace_back("--threshold", fmt::format("{}", *look.threshold));
  }
  if (look.opacity && look.opacities.empty())
    words.emplace_back("--opacity", fmt::format("{}", *look.opacity));
  if (!look.map.empty()) words.emplace_back("--map", look.map);
  if (look.range) words.emplace_back("--range", listed(*look.range));
  if (look.light == LookOptions::Light::kOn) words.emplace_back("--shade", "");
  if (look.light == LookOptions::Light::kOff) words.emplace_back("--no-shade", "");
  if (look.full_gradient) {
    words.emplace_back("--modulate", "");
    words.emplace_back("--full-gradient", fmt::format("{}", *look.full_gradient));
  }
  words.emplace_back("--mode", name(look.mode));
  return words;
}

std::vector<OptionWord> pictureWords(const ViewState& state) {
  std::vector<OptionWord> words;
  addView(words, state.view);
  if (state.time != 0) words.emplace_back("--time", fmt::format("{}", state.time));
  if (state.step_vox) words.emplace_back("--step", fmt::format("{}", *state.step_vox));
  if (state.crop)
    words.emplace_back("--crop", listed(state.crop->lo) + "," + listed(state.crop->hi));
  for (const PictureOptions::Plane& plane : state.clip_planes)
    words.emplace_back("--clip", fmt::format("{},{}", listed(plane.normal), plane.offset));
  if (state.background) {
    std::string color;
    for (const float channel : *state.background)
      color +=
          fmt::format("{:02x}", std::clamp(static_cast<int>(std::lround(channel * 255)), 0, 255));
    words.emplace_back("--background", color);
  }
  return words;
}

std::string renderCommand(const ViewedVolume& volume, const ViewState& state,
                          const std::string& look, int width, int height,
                          const std::string& output) {
  std::string command = "sluice render";
  for (const std::string& path : volume.paths) command += " " + shellWord(asOperand(path));
  const auto add = [&](const std::vector<OptionWord>& words) {
    // A single word each, so that a value may begin with a minus.
    for (const auto& [option, value] : words)
      command += " " + (value.empty() ? option : option + "=" + shellWord(value));
  };
  add(volumeWords(volume.options));
  if (look.empty()) {
    add(lookWords(state.look));
  } else {
    command += " " + look;
    const auto words = lookWords(state.look);
    add({words.back()});  // the mode
  }
  add(pictureWords(state));
  return command + fmt::format(" --size {}x{} -o {}", width, height, shellWord(asOperand(output)));
}

std::string framesCommand(const std::string& state_file, int width, int height,
                          const std::string& output) {
  return fmt::format("sluice render --state={} --size {}x{} -o {}", shellWord(state_file), width,
                     height, shellWord(asOperand(output)));
}

}  // namespace sluice
