// The colours over the picture: one bar with the values at its ends, or a row for each channel.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "src/view/state/editing/look_edit.h"
#include "src/view/window/panels/overlay_text.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

using Colors = std::vector<ShownLook::Color>;

ImU32 inkOf(const Rgb& rgb) {
  return ImGui::GetColorU32(
      {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]), 1});
}

std::string wordOf(double value) {
  return fmt::format("{:.4g}", value);
}
float widthOf(const std::string& words) {
  return ImGui::CalcTextSize(words.c_str()).x;
}

// A map of one value has no length to divide by (shareOf()).
bool hasBar(const Colors& colors) {
  return colors.size() > 1 && colors.back().value > colors.front().value;
}

// The part of a bar at which a value lies, from 0 to 1.
float shareOf(const Colors& colors, double value) {
  const double lo = colors.front().value, hi = colors.back().value;
  return static_cast<float>((value - lo) / (hi - lo));
}

// The left end of the bar's numbers.
float leftOfUprightBar(const Colors& colors, const Area& area) {
  const float wider =
      std::max(widthOf(wordOf(colors.front().value)), widthOf(wordOf(colors.back().value)));
  return area.x + area.width - 24 - 6 - wider;
}

void uprightBar(const Colors& colors, const Area& area, ImDrawList& to) {
  const float x = area.x + area.width - 24, top = area.y + 20;
  const float height = std::min(160.0F, area.height / 3);
  const auto y = [&](double value) { return top + height * (1 - shareOf(colors, value)); };
  for (size_t i = 0; i + 1 < colors.size(); ++i) {
    const ImU32 below = inkOf(colors[i].rgb), above = inkOf(colors[i + 1].rgb);
    to.AddRectFilledMultiColor({x, y(colors[i + 1].value)}, {x + 12, y(colors[i].value)}, above,
                               above, below, below);
  }
  for (const double value : {colors.front().value, colors.back().value}) {
    const std::string words = wordOf(value);
    overlayText(to, {x - 6 - widthOf(words), y(value) - 7}, words);
  }
}

// The row of a channel: "GFP 400 [bar] 3000".
struct Row {
  const ShownLook::Channel* channel;
  std::string name, lo, hi;
};

std::vector<Row> rowsOf(const ShownLook& look) {
  std::vector<Row> rows;
  rows.reserve(look.channels.size());
  for (const ShownLook::Channel& channel : look.channels)
    // Hidden channels and labels have no range of values that a bar could show.
    if (channel.opacity > 0 && !channel.labels && hasBar(channel.colors))
      rows.push_back({&channel, titleOf(channel), wordOf(channel.colors.front().value),
                      wordOf(channel.colors.back().value)});
  return rows;
}

constexpr float kBar = 60, kGap = 6;

struct RowWidths {
  float name = 0, lo = 0, hi = 0;
};

RowWidths widthsOf(const std::vector<Row>& rows) {
  RowWidths widths;
  for (const Row& row : rows) {
    widths.name = std::max(widths.name, widthOf(row.name));
    widths.lo = std::max(widths.lo, widthOf(row.lo));
    widths.hi = std::max(widths.hi, widthOf(row.hi));
  }
  return widths;
}

void channelBars(WindowState& window, const Area& area, ImDrawList& to) {
  const std::vector<Row> rows = rowsOf(window.volume.look);
  const float font = ImGui::GetFontSize(), row_height = font + 4;
  // All rows share the widest texts, so that the bars lie below each other.
  const auto [name_width, lo_width, hi_width] = widthsOf(rows);
  const float right = area.x + area.width - 12, to_x = right - hi_width - kGap, x = to_x - kBar;
  float y = area.y + 12;
  for (const auto& [channel, name, lo, hi] : rows) {
    const Colors& colors = channel->colors;
    const auto at = [&](double value) { return x + kBar * shareOf(colors, value); };
    for (size_t i = 0; i + 1 < colors.size(); ++i) {
      const ImU32 before = inkOf(colors[i].rgb), behind = inkOf(colors[i + 1].rgb);
      to.AddRectFilledMultiColor({at(colors[i].value), y + 2}, {at(colors[i + 1].value), y + font},
                                 before, behind, behind, before);
    }
    overlayText(to, {to_x + kGap, y}, hi);
    overlayText(to, {x - kGap - widthOf(lo), y}, lo);
    overlayText(to, {x - 3 * kGap - lo_width - widthOf(name), y}, name);
    window.log.control(fmt::format("channel {} bar", channel->channel), x, y + 2, kBar, font - 2);
    y += row_height;
  }
}

}  // namespace

float colorBarsLeft(const WindowState& window, const Area& area) {
  // The readings in the upper left corner wrap before the bars, so that this must agree with what
  // drawColorBars() draws.
  const float right = area.x + area.width;
  if (window.state().look.mode == LookOptions::Mode::kDepthMaximum) return right;
  const ShownLook& look = window.volume.look;
  if (!look.channels.empty()) {
    const std::vector<Row> rows = rowsOf(look);
    const RowWidths widths = widthsOf(rows);
    if (rows.empty()) return right;
    return right - 12 - widths.hi - 4 * kGap - kBar - widths.lo - widths.name;
  }
  return !look.labels && hasBar(look.colors) ? leftOfUprightBar(look.colors, area) : right;
}

void drawColorBars(WindowState& window, const Area& area) {
  if (window.state().look.mode == LookOptions::Mode::kDepthMaximum) return;  // colours of depths
  ImDrawList& to = *ImGui::GetWindowDrawList();
  const ShownLook& look = window.volume.look;
  if (!look.channels.empty())
    channelBars(window, area, to);
  else if (!look.labels && hasBar(look.colors))
    uprightBar(look.colors, area, to);
}

}  // namespace sluice
