// How several channels are combined, and a row for each: whether it shows, its colour, the values
// that its colours span, and its opacity.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "src/view/state/editing/look_edit.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

using Channel = ShownLook::Channel;

// The look that the user set last. The picture that shows it may not be there yet.
LookOptions::Channel asked(const WindowState& window, const Channel& channel) {
  LookOptions look = window.state().look;
  return channelOf(look, channel.channel);
}

template <class Change>
void edit(WindowState& window, const Channel& channel, const Change& change) {
  window.edit([&](ViewState& next) { change(channelOf(next.look, channel.channel)); });
}

// A channel that is hidden has no opacity; shown again, it has the one from before.
void showing(WindowState& window, const Channel& channel) {
  const double opacity = asked(window, channel).opacity.value_or(channel.opacity);
  bool shows = opacity > 0;
  if (ImGui::Checkbox("##shows", &shows)) {
    // The opacity from before is no part of the view, so it is kept beside it and not saved.
    auto& before = window.panels.hidden_opacities;
    std::optional<double> next = 0.0;
    if (!shows)
      before[channel.channel] = opacity;
    else
      next =
          before.contains(channel.channel) ? std::optional(before[channel.channel]) : std::nullopt;
    edit(window, channel, [&](LookOptions::Channel& own) { own.opacity = next; });
  }
  window.log.control(fmt::format("channel {} shows", channel.channel));
}

void color(WindowState& window, const Channel& channel) {
  if (const auto chosen = colorField(channel.rgb))
    edit(window, channel, [&](LookOptions::Channel& own) { own.map = *chosen; });
  window.log.control(fmt::format("channel {} color", channel.channel));
}

void range(WindowState& window, const Channel& channel) {
  const auto values = asked(window, channel).range.value_or(channel.range);
  auto lo = static_cast<float>(values[0]), hi = static_cast<float>(values[1]);
  // A range of almost no width could otherwise never be widened again.
  const auto speed = std::max(std::abs(hi - lo) / 300, 1e-6F);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::DragFloatRange2("##range", &lo, &hi, speed, 0, 0, "from %.5g", "to %.5g") && lo != hi)
    edit(window, channel, [&](LookOptions::Channel& own) {
      own.range = {static_cast<double>(lo), static_cast<double>(hi)};
      if (!own.opacity) own.opacity = channel.opacity;  // a range alone has another one
    });
  window.log.control(fmt::format("channel {} range", channel.channel));
}

void opacity(WindowState& window, const Channel& channel) {
  const double now = asked(window, channel).opacity.value_or(channel.opacity);
  auto shown = static_cast<float>(now);
  ImGui::SetNextItemWidth(-1);
  // The slider would show a hidden channel again and contradict its box.
  ImGui::BeginDisabled(!(now > 0));
  if (ImGui::SliderFloat("##opacity", &shown, 0.001F, 1, "opacity %.3f",
                         ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    edit(window, channel,
         [&](LookOptions::Channel& own) { own.opacity = static_cast<double>(shown); });
  ImGui::EndDisabled();
  window.log.control(fmt::format("channel {} opacity", channel.channel));
}

// Added up, or blended as one medium, which the CPU device draws in composite mode.
void combining(WindowState& window) {
  const LookOptions& look = window.state().look;
  bool blends = blendsChannels(look, window.state(), window.volume.look);
  const bool can_blend = look.mode == LookOptions::Mode::kComposite;
  ImGui::BeginDisabled(!can_blend && !blends);
  if (ImGui::Checkbox("one medium", &blends))
    window.edit([&](ViewState& next) {
      next.look.combine = blends ? LookOptions::Combine::kBlend : LookOptions::Combine::kAdd;
    });
  ImGui::EndDisabled();
  window.log.control("one medium");
}

}  // namespace

void channelsPanel(WindowState& window) {
  combining(window);
  for (const Channel& channel : window.volume.look.channels) {
    // Names tell the rows apart even if channels come or go between two frames.
    ImGui::PushID(channel.channel.c_str());
    showing(window, channel);
    ImGui::SameLine();
    color(window, channel);
    ImGui::SameLine();
    ImGui::TextUnformatted(titleOf(channel).c_str());
    range(window, channel);
    opacity(window, channel);
    ImGui::PopID();
  }
}

}  // namespace sluice
