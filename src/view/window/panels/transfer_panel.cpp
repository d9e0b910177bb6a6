#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>

#include "src/base/files/file_kind.h"
#include "src/view/state/editing/transfer_edit.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

constexpr float kHeight = 106, kReach = 9;  // screen units

struct Plot {
  ImVec2 lo, size;
  std::array<double, 2> range;  // range of values

  double shareOf(double value) const {
    return range[1] > range[0] ? (value - range[0]) / (range[1] - range[0]) : 0.5;
  }
  ImVec2 at(double value, double height) const {
    // Points may lie far outside of the range. Lines to them end beyond the edges of the plot,
    // since the screen's floats do not reach so far.
    return {lo.x + static_cast<float>(std::clamp(shareOf(value), -1.0, 2.0)) * size.x,
            lo.y + (1 - static_cast<float>(height)) * size.y};
  }
  double valueAt(float x) const {
    return range[0] +
           std::clamp(static_cast<double>((x - lo.x) / size.x), 0.0, 1.0) * (range[1] - range[0]);
  }
  double heightAt(float y) const {
    return std::clamp(1 - static_cast<double>((y - lo.y) / size.y), 0.0, 1.0);
  }
};

void drawHistogram(const WindowState& window, const Plot& plot, ImDrawList& to) {
  const ValueHistogram& histogram = window.volume.news->histogram;
  uint64_t most = 1;
  for (const uint64_t count : histogram.counts) most = std::max(most, count);
  const auto shown = [&](uint64_t count) {
    const auto c = static_cast<double>(count), m = static_cast<double>(most);
    // The background of a volume has most of its voxels, so that linear counts show little else.
    return window.panels.is_log_histogram ? std::log1p(c) / std::log1p(m) : c / m;
  };
  const auto bins = static_cast<double>(histogram.counts.size());
  const double width = (histogram.hi - histogram.lo) / bins;
  for (size_t i = 0; i < histogram.counts.size(); ++i) {
    if (histogram.counts[i] == 0) continue;
    const double value = histogram.lo + width * static_cast<double>(i);
    const ImVec2 top = plot.at(value, shown(histogram.counts[i]));
    // A bin is at least a pixel wide, or sparse histograms would vanish.
    const float right = plot.at(value + width, 0).x;
    to.AddRectFilled(top, {std::max(right, top.x + 1), plot.lo.y + plot.size.y},
                     IM_COL32(110, 120, 135, 255));
  }
}

ImU32 colorOf(const std::array<double, 3>& rgb) {
  return ImGui::GetColorU32(
      {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]), 1});
}

void drawColors(const WindowState& window, const Plot& plot, ImDrawList& to) {
  const auto& colors = window.volume.look.colors;
  const float top = plot.lo.y + plot.size.y + 3;
  for (size_t i = 0; i + 1 < colors.size(); ++i) {
    const ImU32 a = colorOf(colors[i].rgb), b = colorOf(colors[i + 1].rgb);
    const float from = std::max(plot.at(colors[i].value, 0).x, plot.lo.x);
    const float end = std::min(plot.at(colors[i + 1].value, 0).x, plot.lo.x + plot.size.x);
    if (end > from) to.AddRectFilledMultiColor({from, top}, {end, top + 8}, a, b, b, a);
  }
}

void drawPoints(const WindowState& window, const Plot& plot, const OpacityPoints& points,
                ImDrawList& to) {
  const ImU32 line = IM_COL32(255, 190, 90, 255);
  for (size_t i = 0; i + 1 < points.size(); ++i)
    to.AddLine(plot.at(points[i].value, heightOf(points[i].opacity)),
               plot.at(points[i + 1].value, heightOf(points[i + 1].opacity)), line, 1.5F);
  for (size_t i = 0; i < points.size(); ++i)
    to.AddCircleFilled(plot.at(points[i].value, heightOf(points[i].opacity)),
                       window.pointer.point == i ? 6.0F : 4.0F, line);
}

// The left button takes a point, or puts a new one if there is none; the right one removes it.
void edit(WindowState& window, const Plot& plot) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const double value = plot.valueAt(mouse.x), height = plot.heightAt(mouse.y);
  const bool takes = ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Left);
  const bool removes = ImGui::IsItemHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Right);
  // A click that does not move must not move the point, so that a drag begins after a pixel.
  const bool drags = window.pointer.point && ImGui::IsMouseDragging(ImGuiMouseButton_Left, 1);
  if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) window.pointer.point.reset();
  if (!takes && !removes && !drags) return;
  ViewState next = window.state();
  // Any look becomes one of points at the first edit.
  next.look = byPoints(next.look, window.volume.look, window.valueRange());
  OpacityPoints& points = next.look.opacities;
  const auto near =
      pointAt(points, plot.range, plot.shareOf(value), height,
              static_cast<double>(kReach / plot.size.x), static_cast<double>(kReach / plot.size.y));
  if (removes) {
    if (near) removePoint(points, *near);
  } else if (takes) {
    window.pointer.point = near ? *near : addPoint(points, value, opacityAtHeight(height));
    // Undo may have taken points away during the drag.
  } else if (*window.pointer.point < points.size()) {
    movePoint(points, *window.pointer.point, value, opacityAtHeight(height));
  }
  if (takes && near) return;  // taken, not changed
  window.change(next);
}

}  // namespace

void transferPanel(WindowState& window) {
  Plot plot;
  plot.lo = ImGui::GetCursorScreenPos();
  plot.size = {ImGui::GetContentRegionAvail().x, kHeight * ImGui::GetIO().FontGlobalScale};
  plot.range = window.valueRange();
  // The button makes the plot an item, so that ImGui gives it the clicks and does not scroll or
  // move the panel with them.
  ImGui::InvisibleButton("transfer", {plot.size.x, plot.size.y + 12},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
  window.log.control("transfer", plot.lo.x, plot.lo.y, plot.size.x, plot.size.y);
  edit(window, plot);
  ImDrawList& to = *ImGui::GetWindowDrawList();
  to.PushClipRect(plot.lo, {plot.lo.x + plot.size.x, plot.lo.y + plot.size.y + 12}, true);
  to.AddRectFilled(plot.lo, {plot.lo.x + plot.size.x, plot.lo.y + plot.size.y},
                   IM_COL32(28, 29, 32, 255));
  drawHistogram(window, plot, to);
  drawColors(window, plot, to);
  // Any look shows its opacities as points; the state has none until the first edit.
  OpacityPoints points = window.state().look.opacities;
  if (points.empty())
    for (const ShownLook::Opacity& point : window.volume.look.opacities)
      points.push_back({point.value, point.opacity});
  drawPoints(window, plot, points, to);
  to.PopClipRect();
  ImGui::Checkbox("logarithmic", &window.panels.is_log_histogram);
  window.log.control("logarithmic");
  ImGui::SetNextItemWidth(-ImGui::CalcTextSize("load  save ").x - 30);
  ImGui::InputTextWithHint("##transfer", "transfer function's file", &window.panels.transfer_file);
  window.log.control("transfer name");
  ImGui::SameLine();
  if (ImGui::Button("load") && !window.panels.transfer_file.empty()) {
    ViewState next = window.state();
    // A file stands beside none of these (optionsApart()), and they would hide what it has.
    next.look.threshold.reset();
    next.look.opacities.clear();
    next.look.labels = false;
    next.look.map.clear();
    next.look.transfer_file = window.panels.transfer_file;
    window.change(next);
  }
  window.log.control("load transfer");
  ImGui::SameLine();
  if (ImGui::Button("save") && !window.panels.transfer_file.empty())
    window.desk.saveText(window.panels.transfer_file, window.volume.look.transfer + "\n",
                         FileKind::kTransferFunction);
  window.log.control("save transfer");
}

}  // namespace sluice
