#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "src/view/window/panels.h"

namespace sluice {
namespace {

PictureOptions::Box boxOf(const Sitting& sitting) {
  return sitting.state().crop.value_or(PictureOptions::Box{{0, 0, 0}, sitting.info().dims});
}

// At least two voxel planes stay; a box of all is none.
void setBox(Sitting& sitting, PictureOptions::Box box) {
  const auto& dims = sitting.info().dims;
  for (size_t a = 0; a < 3; ++a) {
    box.lo[a] = std::clamp<int64_t>(box.lo[a], 0, std::max<int64_t>(0, dims[a] - 2));
    box.hi[a] = std::clamp<int64_t>(box.hi[a], std::min(box.lo[a] + 2, dims[a]), dims[a]);
  }
  ViewState next = sitting.state();
  const PictureOptions::Box all{{0, 0, 0}, dims};
  next.crop = box == all ? std::nullopt : std::optional(box);
  sitting.change(next);
}

Vec3d worldOf(const Sitting& sitting, const std::array<double, 3>& voxel) {
  const VolumeInfo& info = sitting.info();
  Vec3d world{info.origin[0], info.origin[1], info.origin[2]};
  for (size_t a = 0; a < 3; ++a)
    world = world +
            Vec3d{info.axes[a][0], info.axes[a][1], info.axes[a][2]} * (info.spacing[a] * voxel[a]);
  return world;
}

// The middle of a face of the box, in voxels.
std::array<double, 3> faceOf(const PictureOptions::Box& box, int face) {
  std::array<double, 3> middle{};
  for (size_t a = 0; a < 3; ++a)
    middle[a] = (static_cast<double>(box.lo[a]) + static_cast<double>(box.hi[a] - 1)) / 2;
  const auto axis = static_cast<size_t>(face / 2);
  middle[axis] = static_cast<double>(face % 2 == 0 ? box.lo[axis] : box.hi[axis] - 1);
  return middle;
}

void planes(Sitting& sitting) {
  auto& shown = sitting.state().clip_planes;
  if (shown.size() < 6 && ImGui::Button("cut here")) {
    // Off goes what lies before the target, as it is looked at.
    const PlacedAxes axes = axesOf(sitting.state().view);
    const auto& target = sitting.state().view.look_at->target;
    ViewState next = sitting.state();
    next.clip_planes.push_back({{axes.back.x, axes.back.y, axes.back.z},
                                dot(axes.back, Vec3d{target[0], target[1], target[2]})});
    sitting.change(next);
  }
  sitting.log.control("cut here");
  const auto radius = static_cast<float>(sitting.ground.radius);
  for (size_t i = 0; i < sitting.state().clip_planes.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const PictureOptions::Plane plane = sitting.state().clip_planes[i];
    auto offset = static_cast<float>(plane.offset);
    const double middle =
        dot(Vec3d{plane.normal[0], plane.normal[1], plane.normal[2]}, sitting.ground.center);
    ImGui::SetNextItemWidth(-70);
    if (ImGui::SliderFloat("##plane", &offset, static_cast<float>(middle) - radius,
                           static_cast<float>(middle) + radius, "plane %.4g")) {
      ViewState next = sitting.state();
      next.clip_planes[i].offset = static_cast<double>(offset);
      sitting.change(next);
    }
    ImGui::SameLine();
    if (ImGui::Button("remove")) {
      ViewState next = sitting.state();
      next.clip_planes.erase(next.clip_planes.begin() + static_cast<std::ptrdiff_t>(i));
      sitting.change(next);
    }
    ImGui::PopID();
  }
}

}  // namespace

int boxHandleAt(const Sitting& sitting, const Area& area, float pixels, float x, float y) {
  if (!sitting.isOpen() || !sitting.state().crop) return -1;
  constexpr double kReach = 10;  // screen units
  for (int face = 0; face < 6; ++face) {
    const auto at = paneOf(sitting.state().view, worldOf(sitting, faceOf(boxOf(sitting), face)),
                           sitting.pane, sitting.ground);
    if (at &&
        std::hypot(at->x / static_cast<double>(pixels) - static_cast<double>(x - area.x),
                   at->y / static_cast<double>(pixels) - static_cast<double>(y - area.y)) < kReach)
      return face;
  }
  return -1;
}

void dragBoxHandle(Sitting& sitting, int face, float dx, float dy, float pixels) {
  PictureOptions::Box box = boxOf(sitting);
  const auto axis = static_cast<size_t>(face / 2);
  // How a voxel along the axis is seen.
  std::array<double, 3> voxel = faceOf(box, face);
  const auto here =
      paneOf(sitting.state().view, worldOf(sitting, voxel), sitting.pane, sitting.ground);
  voxel[axis] += 1;
  const auto next =
      paneOf(sitting.state().view, worldOf(sitting, voxel), sitting.pane, sitting.ground);
  if (!here || !next) return;
  const double ax = next->x - here->x, ay = next->y - here->y, length = ax * ax + ay * ay;
  if (length < 1e-12) return;
  // Parts of a voxel are kept for the next movement.
  sitting.handle_rest += static_cast<double>(pixels) *
                         (static_cast<double>(dx) * ax + static_cast<double>(dy) * ay) / length;
  const auto whole = static_cast<int64_t>(sitting.handle_rest);
  if (whole == 0) return;
  sitting.handle_rest -= static_cast<double>(whole);
  (face % 2 == 0 ? box.lo : box.hi)[axis] += whole;
  setBox(sitting, box);
}

void cutPanel(Sitting& sitting) {
  const auto& dims = sitting.info().dims;
  constexpr std::array kNames{"x", "y", "z"};
  PictureOptions::Box box = boxOf(sitting);
  for (size_t a = 0; a < 3; ++a) {
    auto lo = static_cast<int>(box.lo[a]), hi = static_cast<int>(box.hi[a]);
    ImGui::PushID(static_cast<int>(a));
    ImGui::SetNextItemWidth(-1);
    if (ImGui::DragIntRange2("##crop", &lo, &hi, static_cast<float>(dims[a]) / 400, 0,
                             static_cast<int>(dims[a]), (std::string(kNames[a]) + " %d").c_str(),
                             "to %d")) {
      box.lo[a] = lo;
      box.hi[a] = hi;
      setBox(sitting, box);
    }
    sitting.log.control("crop " + std::string(kNames[a]));
    ImGui::PopID();
  }
  if (ImGui::Button("no clip box") && sitting.state().crop) setBox(sitting, {{0, 0, 0}, dims});
  sitting.log.control("no clip box");
  ImGui::SameLine();
  if (!sitting.state().crop) {
    if (ImGui::Button("box with handles")) {
      for (size_t a = 0; a < 3; ++a) {
        box.lo[a] = dims[a] / 8;
        box.hi[a] = dims[a] - dims[a] / 8;
      }
      setBox(sitting, box);
    }
    sitting.log.control("box with handles");
    ImGui::SameLine();
  }
  planes(sitting);
}

void drawBoxHandles(Sitting& sitting, const Area& area, float pixels) {
  if (!sitting.state().crop) return;
  ImDrawList& to = *ImGui::GetWindowDrawList();
  const auto screen = [&](const std::array<double, 3>& voxel) -> std::optional<ImVec2> {
    const auto at =
        paneOf(sitting.state().view, worldOf(sitting, voxel), sitting.pane, sitting.ground);
    if (!at) return std::nullopt;
    return ImVec2{area.x + static_cast<float>(at->x) / pixels,
                  area.y + static_cast<float>(at->y) / pixels};
  };
  const PictureOptions::Box box = *sitting.state().crop;
  const auto corner = [&](int which) {
    std::array<double, 3> voxel{};
    for (size_t a = 0; a < 3; ++a)
      voxel[a] = static_cast<double>(((which >> a) & 1) != 0 ? box.hi[a] - 1 : box.lo[a]);
    return screen(voxel);
  };
  for (int from = 0; from < 8; ++from)
    for (int axis = 0; axis < 3; ++axis) {
      if (((from >> axis) & 1) != 0) continue;
      const auto a = corner(from), b = corner(from | (1 << axis));
      if (a && b) to.AddLine(*a, *b, IM_COL32(255, 190, 90, 120));
    }
  for (int face = 0; face < 6; ++face) {
    const auto at = screen(faceOf(box, face));
    if (!at) continue;
    to.AddCircleFilled(*at, 5, IM_COL32(255, 190, 90, 220));
  }
  if (const auto at = screen(faceOf(box, 1))) sitting.log.control("handle x", at->x, at->y, 0, 0);
}

}  // namespace sluice
