#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

std::string bytes(uint64_t count) {
  constexpr std::array kUnits{"B", "KiB", "MiB", "GiB", "TiB"};
  auto value = static_cast<double>(count);
  size_t unit = 0;
  while (value >= 1024 && unit + 1 < kUnits.size()) {
    value /= 1024;
    ++unit;
  }
  return fmt::format("{:.{}f} {}", value, unit == 0 ? 0 : 1, kUnits[unit]);
}

void level(const char* name, const LevelReport& report) {
  const double share = report.budget_bytes == 0 ? 0
                                                : static_cast<double>(report.current_bytes) /
                                                      static_cast<double>(report.budget_bytes);
  ImGui::ProgressBar(
      static_cast<float>(share), {-1, 0},
      fmt::format("{}: {} of {}", name, bytes(report.current_bytes), bytes(report.budget_bytes))
          .c_str());
  ImGui::TextDisabled("%s", fmt::format("{} hits, {} misses, {} loaded, {} went", report.hits,
                                        report.misses, report.loads, report.evictions)
                                .c_str());
}

// A square a cell, as many in a row as fit; the colour of each.
template <class Color>
void squares(size_t count, size_t columns, const Color& color) {
  const ImVec2 lo = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const float side = std::clamp(width / static_cast<float>(columns), 1.0F, 10.0F);
  ImDrawList& to = *ImGui::GetWindowDrawList();
  for (size_t i = 0; i < count; ++i) {
    const size_t column = i % columns, row = i / columns;
    const float x = lo.x + side * static_cast<float>(column),
                y = lo.y + side * static_cast<float>(row);
    const float gap = side > 3 ? 1 : 0;
    to.AddRectFilled({x, y}, {x + side - gap, y + side - gap}, color(i));
  }
  // Drawing into the list takes no room in the panel, so an empty item of this size does.
  ImGui::Dummy({width, side * std::ceil(static_cast<float>(count) / static_cast<float>(columns))});
}

ImU32 chunkColor(uint32_t chunk) {
  if (chunk == 0) return IM_COL32(60, 62, 66, 255);
  // The golden ratio spreads the hues of numbers that follow each other.
  const float hue = std::fmod(static_cast<float>(chunk) * 0.618034F, 1.0F);
  float r = 0, g = 0, b = 0;
  ImGui::ColorConvertHSVtoRGB(hue, 0.55F, 0.85F, r, g, b);
  return ImGui::GetColorU32({r, g, b, 1});
}

void pagesMap(const RenderReport& report) {
  ImGui::TextDisabled("pages of the texture cache, a colour a chunk");
  // A texture cache may have millions of pages, and each square is two triangles in each frame.
  constexpr size_t kMost = 8192;
  const size_t count = std::min(report.page_chunks.size(), kMost);
  const size_t columns = count > 1024 ? 96 : 48;
  squares(count, columns, [&](size_t i) { return chunkColor(report.page_chunks[i]); });
}

void blocksMap(WindowState& window) {
  const RenderReport& report = window.volume.report;
  const auto& grid = report.block_grid;
  // The first report with maps comes a moment after the box is ticked.
  if (report.block_classes.empty()) return;
  // The layer that the cross hair is in.
  const int64_t layer = std::clamp<int64_t>(
      window.state().cross[2] * grid[2] / window.info().dims[2], 0, grid[2] - 1);
  ImGui::TextDisabled(
      "%s",
      fmt::format("blocks of layer {} of {}: empty, trimmed, full", layer + 1, grid[2]).c_str());
  const auto plane = static_cast<size_t>(grid[0] * grid[1]);
  const size_t first = plane * static_cast<size_t>(layer);
  squares(plane, static_cast<size_t>(grid[0]), [&](size_t i) {
    switch (report.block_classes[first + i]) {
      case 1:
        return IM_COL32(150, 150, 155, 255);
      case 2:
        return IM_COL32(20, 20, 22, 255);
      default:
        return IM_COL32(240, 240, 240, 255);
    }
  });
}

}  // namespace

void levelsPanel(WindowState& window) {
  const RenderReport& report = window.volume.report;
  ImGui::TextDisabled(
      "%s", fmt::format("disk: {} read; picture {:.0f} ms, of it drawing {:.0f}",
                        bytes(report.read_bytes), 1e3 * report.seconds, 1e3 * report.draw_seconds)
                .c_str());
  level("volume buffer", report.volume_buffer);
  level("texture buffer", report.texture_buffer);
  level("texture cache", report.texture_cache);
  ImGui::TextDisabled(
      "%s", fmt::format("blocks: {} white, {} grey, {} black; {} pages came", report.white,
                        report.grey, report.black, report.pages_loaded)
                .c_str());
  ImGui::Checkbox("maps", &window.panels.shows_maps);
  window.log.control("maps");
  if (!window.panels.shows_maps) return;
  pagesMap(report);
  blocksMap(window);
}

}  // namespace sluice
