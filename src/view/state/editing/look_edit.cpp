#include "src/view/state/editing/look_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "src/base/looks/surface_look.h"

namespace sluice {

LookOptions::Channel& channelOf(LookOptions& look, std::string_view channel) {
  const auto known = std::ranges::find(look.channels, channel, &LookOptions::Channel::channel);
  if (known != look.channels.end()) return *known;
  // A channel without options of its own has no entry until the first edit.
  return look.channels.emplace_back(LookOptions::Channel{.channel = std::string(channel)});
}

std::string titleOf(const ShownLook::Channel& channel) {
  return channel.name.empty() ? "channel " + channel.channel : channel.name;
}

Rgb colorAt(const ShownLook& look, double value) {
  const auto above = std::ranges::upper_bound(look.colors, value, {}, &ShownLook::Color::value);
  if (look.colors.empty()) return {1, 1, 1};
  if (above == look.colors.begin()) return above->rgb;
  const ShownLook::Color& below = *std::prev(above);
  if (above == look.colors.end()) return below.rgb;
  const double share = (value - below.value) / (above->value - below.value);
  Rgb rgb{};
  for (size_t i = 0; i < 3; ++i) rgb[i] = std::lerp(below.rgb[i], above->rgb[i], share);
  return rgb;
}

std::string valueText(const ShownLook& look, double value) {
  const auto named =
      std::ranges::lower_bound(look.label_names, value, {}, &ShownLook::LabelName::label);
  if (named == look.label_names.end() || named->label != value)
    return fmt::format("{:.5g}", value + 0.0);  // no minus zero
  return fmt::format("{:g} ({})", value, named->name);
}

std::string readingText(const ShownLook& look, const VoxelProbe& reading, const std::string& unit) {
  // Rounded or with 0 added, no zero has a minus.
  const auto& [voxel, world, value] = reading;
  return fmt::format("{} at {:.4g}, {:.4g}, {:.4g}{} (voxel {}, {}, {})", valueText(look, value),
                     world[0] + 0.0, world[1] + 0.0, world[2] + 0.0, unit.empty() ? "" : " " + unit,
                     std::llround(voxel[0]), std::llround(voxel[1]), std::llround(voxel[2]));
}

bool blendsChannels(const LookOptions& look, const PictureOptions& picture,
                    const ShownLook& shown) {
  if (look.combine) return *look.combine == LookOptions::Combine::kBlend;
  const PictureOptions::Lighting& light = picture.lighting;
  return shown.blends && light.shadows.value_or(0) == 0 && light.occlusion.value_or(0) == 0;
}

bool takesSurface(const LookOptions& look, const ShownLook& shown) {
  // Surfaces are the first volume's, of one channel; they are not blended.
  const auto own = std::ranges::count_if(
      shown.channels, [](const ShownLook::Channel& channel) { return channel.channel != "over"; });
  return look.mode == LookOptions::Mode::kComposite && !shown.labels && own <= 1 &&
         look.combine != LookOptions::Combine::kBlend && look.surfaces.size() < kMostSurfaces;
}

LookOptions withSurface(LookOptions look, std::array<double, 2> values) {
  double value = look.threshold.value_or(std::midpoint(values[0], values[1]));
  const double step = (values[1] - values[0]) / 16;
  // A surface at a value that has one already would hide it.
  while (step > 0 && std::ranges::find(look.surfaces, value, &LookOptions::Surface::value) !=
                         look.surfaces.end())
    value = value + step <= values[1] ? value + step : values[0] + step / 3;
  look.surfaces.push_back({.value = value});
  return look;
}

}  // namespace sluice
