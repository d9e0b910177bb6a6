#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

// The usual name of the slices across an axis of voxels, if the file tells what its axes mean.
std::string nameOf(const VolumeInfo& info, size_t axis) {
  constexpr std::array kPlain{"across x", "across y", "across z"};
  if (info.frame != "RAS" && info.frame != "LPS") return kPlain[axis];
  size_t main = 0;
  for (size_t a = 1; a < 3; ++a)
    if (std::abs(info.axes[axis][a]) > std::abs(info.axes[axis][main])) main = a;
  constexpr std::array kNames{"sagittal", "coronal", "axial"};
  return kNames[main];
}

bool isOfStep(const WindowState& window, size_t axis) {
  return window.slices[axis].time == window.state().time;
}

// The value of a slice at a voxel, or nothing if it has no number there or is not read yet.
std::optional<VoxelProbe> reading(const WindowState& window, size_t axis,
                                  std::array<int64_t, 3> voxel) {
  const SliceValues& values = window.slices[axis].values;
  if (!isOfStep(window, axis) || window.slices[axis].at != window.state().cross[axis])
    return std::nullopt;
  const size_t across = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
  // A large slice has every second or third voxel.
  const auto taken = [&](size_t a, int count) {
    const int64_t index = std::min<int64_t>(voxel[a] / values.every, count - 1);
    voxel[a] = index * values.every;
    return static_cast<size_t>(index);
  };
  const size_t column = taken(across, values.width), row = taken(down, values.height);
  const float value = values.values[row * static_cast<size_t>(values.width) + column];
  if (std::isnan(value)) return std::nullopt;
  VoxelProbe probe;
  for (size_t a = 0; a < 3; ++a) probe.voxel[a] = static_cast<double>(voxel[a]);
  const Vec3d world = worldOf(window, probe.voxel);
  probe.world = {world.x, world.y, world.z};
  probe.value = static_cast<double>(value);
  return probe;
}

void slice(WindowState& window, size_t axis, const Area& area) {
  const VolumeInfo& info = window.info();
  const size_t across = axis == 0 ? 1 : 0, down = axis == 2 ? 1 : 2;
  const auto extent = [&](size_t a) {
    return static_cast<float>(info.spacing[a] * static_cast<double>(info.dims[a]));
  };
  // Slices have the proportions of the world, so that voxels that are not cubes are not shown as
  // squares.
  const float scale = std::min(area.width / extent(across), area.height / extent(down));
  const ImVec2 size{extent(across) * scale, extent(down) * scale};
  const ImVec2 lo{area.x + (area.width - size.x) / 2, area.y + (area.height - size.y) / 2};
  ImDrawList& to = *ImGui::GetWindowDrawList();
  // The rows run upwards if the patient's head, or whatever else is up, is at the end of an axis.
  const bool turned = down == 2 && info.frame != "rows";
  // A step that cannot be read has no slice, least of all that of another step.
  const bool is_shown = isOfStep(window, axis) || !hasFailed(window);
  if (window.slices[axis].texture.id() != nullptr && is_shown)
    to.AddImage(window.slices[axis].texture.id(), lo, {lo.x + size.x, lo.y + size.y},
                {0, turned ? 1.0F : 0.0F}, {1, turned ? 0.0F : 1.0F});
  ImGui::SetCursorScreenPos(lo);
  ImGui::PushID(static_cast<int>(axis));
  ImGui::InvisibleButton("slice", {std::max(1.0F, size.x), std::max(1.0F, size.y)});
  window.log.control(fmt::format("slice {}", axis));
  const ImGuiIO& io = ImGui::GetIO();
  ViewState next = window.state();
  const auto voxelAt = [&](size_t a, float share) {
    return std::clamp<int64_t>(static_cast<int64_t>(share * static_cast<float>(info.dims[a])), 0,
                               info.dims[a] - 1);
  };
  const float row = (io.MousePos.y - lo.y) / size.y;
  std::array<int64_t, 3> pointed = next.cross;
  pointed[across] = voxelAt(across, (io.MousePos.x - lo.x) / size.x);
  pointed[down] = voxelAt(down, turned ? 1 - row : row);
  if (ImGui::IsItemHovered()) window.pointer.slice_value = reading(window, axis, pointed);
  if (ImGui::IsItemActive()) {
    next.cross = pointed;
  } else if (ImGui::IsItemHovered() && io.MouseWheel != 0) {
    next.cross[axis] = std::clamp<int64_t>(next.cross[axis] + (io.MouseWheel > 0 ? 1 : -1), 0,
                                           info.dims[axis] - 1);
  }
  // A move of the cross hair is no step to undo.
  if (next.cross != window.state().cross) window.history.replace(next);
  ImGui::PopID();
  const auto share = [&](size_t a) {
    return (static_cast<float>(window.state().cross[a]) + 0.5F) / static_cast<float>(info.dims[a]);
  };
  const float x = lo.x + share(across) * size.x;
  const float y = lo.y + (turned ? 1 - share(down) : share(down)) * size.y;
  to.AddLine({x, lo.y}, {x, lo.y + size.y}, IM_COL32(255, 190, 90, 130));
  to.AddLine({lo.x, y}, {lo.x + size.x, y}, IM_COL32(255, 190, 90, 130));
  const int64_t at = window.state().cross[axis];
  std::string words = fmt::format("{} {}", nameOf(info, axis), at);
  if (!isOfStep(window, axis))
    words += hasFailed(window) ? " (could not be read)" : " (not read yet)";
  else if (window.slices[axis].at != at)
    words += " (not read yet)";
  to.AddText({area.x + 6, area.y + 4}, IM_COL32(235, 235, 235, 255), words.c_str());
}

}  // namespace

void slicesPane(WindowState& window, const Area& area) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::Begin("slices", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_NoScrollWithMouse);
  // Each slice sets the value if the pointer is over it, so that it is gone when the pointer
  // leaves.
  const auto before = std::exchange(window.pointer.slice_value, std::nullopt);
  const float width = area.width / 3;
  // Axial, coronal, sagittal.
  for (size_t i = 0; i < 3; ++i)
    slice(window, 2 - i,
          {area.x + width * static_cast<float>(i) + 3, area.y + 3, width - 6, area.height - 6});
  const std::optional<VoxelProbe>& now = window.pointer.slice_value;
  if (now && (!before || before->voxel != now->voxel))
    window.log.write({{"slice_value", now->value}, {"voxel", now->voxel}});
  ImGui::End();
}

}  // namespace sluice
