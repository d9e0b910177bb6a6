#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "src/base/looks/view_limits.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

PictureOptions::Box boxOf(const WindowState& window) {
  return window.state().crop.value_or(PictureOptions::Box{{0, 0, 0}, window.info().dims});
}

// At least one voxel plane stays; a box of all is none.
void setBox(WindowState& window, PictureOptions::Box box) {
  const auto& dims = window.info().dims;
  for (size_t a = 0; a < 3; ++a) {
    box.lo[a] = std::clamp<int64_t>(box.lo[a], 0, dims[a] - 1);
    box.hi[a] = std::clamp<int64_t>(box.hi[a], box.lo[a] + 1, dims[a]);
  }
  ViewState next = window.state();
  const PictureOptions::Box all{{0, 0, 0}, dims};
  next.crop = box == all ? std::nullopt : std::optional(box);
  window.change(next);
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

// Two fields for the ends of an interval within 0 and `most`, neither of which passes the other.
// Returns whether the user changed one. ImGui::DragIntRange2() does the same for numbers of 32
// bits.
bool dragInterval(int64_t& lo, int64_t& hi, int64_t most, const std::string& name) {
  const int64_t none = 0, lo_most = std::min(hi, most), hi_least = std::max<int64_t>(lo, 0);
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float half = std::floor((ImGui::CalcItemWidth() - gap) / 2);
  const float speed = static_cast<float>(most) / 400;
  ImGui::BeginGroup();  // one item for the log of controls
  ImGui::SetNextItemWidth(half);
  bool is_changed = ImGui::DragScalar("##from", ImGuiDataType_S64, &lo, speed, &none, &lo_most,
                                      (name + " %lld").c_str());
  ImGui::SameLine(0, gap);
  ImGui::SetNextItemWidth(half);
  is_changed |=
      ImGui::DragScalar("##to", ImGuiDataType_S64, &hi, speed, &hi_least, &most, "to %lld");
  ImGui::EndGroup();
  return is_changed;
}

void planes(WindowState& window) {
  auto& shown = window.state().clip_planes;
  if (shown.size() < kMostAskedPlanes && ImGui::Button("cut here")) cutHere(window);
  window.log.control("cut here");
  const auto radius = static_cast<float>(window.volume.ground.radius);
  for (size_t i = 0; i < window.state().clip_planes.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    // A copy and a new look at the count in each round, because "remove" changes the list that is
    // being walked.
    const PictureOptions::Plane plane = window.state().clip_planes[i];
    // The slider spans the ball around the volume, beyond which a plane cuts all or nothing.
    auto offset = static_cast<float>(plane.offset);
    const double middle =
        dot(Vec3d{plane.normal[0], plane.normal[1], plane.normal[2]}, window.volume.ground.center);
    ImGui::SetNextItemWidth(-70);
    if (ImGui::SliderFloat("##plane", &offset, static_cast<float>(middle) - radius,
                           static_cast<float>(middle) + radius, "plane %.4g")) {
      window.edit(
          [&](ViewState& next) { next.clip_planes[i].offset = static_cast<double>(offset); });
    }
    ImGui::SameLine();
    if (ImGui::Button("remove"))
      window.edit([&](ViewState& next) {
        next.clip_planes.erase(next.clip_planes.begin() + static_cast<std::ptrdiff_t>(i));
      });
    ImGui::PopID();
  }
}

}  // namespace

Vec3d worldOf(const WindowState& window, const std::array<double, 3>& voxel) {
  const VolumeInfo& info = window.info();
  Vec3d world{info.origin[0], info.origin[1], info.origin[2]};
  for (size_t a = 0; a < 3; ++a)
    world = world +
            Vec3d{info.axes[a][0], info.axes[a][1], info.axes[a][2]} * (info.spacing[a] * voxel[a]);
  return world;
}

int boxHandleAt(const WindowState& window, const Area& area, float pixels, float x, float y) {
  // The picture that is shown may be older than the view, and the handles belong to what is seen.
  const ViewState& shown = window.shown.picture.state;
  if (!window.isOpen() || !shown.crop) return -1;
  constexpr double kReach = 10;  // screen units
  for (int face = 0; face < 6; ++face) {
    const auto at = paneOf(shown.view, worldOf(window, faceOf(*shown.crop, face)), window.pane,
                           window.volume.ground);
    if (at &&
        std::hypot(at->x / static_cast<double>(pixels) - static_cast<double>(x - area.x),
                   at->y / static_cast<double>(pixels) - static_cast<double>(y - area.y)) < kReach)
      return face;
  }
  return -1;
}

void dragBoxHandle(WindowState& window, int face, float dx, float dy, float pixels) {
  PictureOptions::Box box = boxOf(window);
  const auto axis = static_cast<size_t>(face / 2);
  // The movement of the pointer is measured along the axis as the pane shows it, by the place of a
  // voxel and of the next one.
  std::array<double, 3> voxel = faceOf(box, face);
  const auto here =
      paneOf(window.state().view, worldOf(window, voxel), window.pane, window.volume.ground);
  voxel[axis] += 1;
  const auto next =
      paneOf(window.state().view, worldOf(window, voxel), window.pane, window.volume.ground);
  if (!here || !next) return;
  const double ax = next->x - here->x, ay = next->y - here->y, length = ax * ax + ay * ay;
  // The axis points at the eye, so no movement tells anything.
  if (length < 1e-12) return;
  // Parts of a voxel are kept for the next movement.
  window.pointer.handle_rest += static_cast<double>(pixels) *
                                (static_cast<double>(dx) * ax + static_cast<double>(dy) * ay) /
                                length;
  const auto whole = static_cast<int64_t>(window.pointer.handle_rest);
  if (whole == 0) return;
  window.pointer.handle_rest -= static_cast<double>(whole);
  (face % 2 == 0 ? box.lo : box.hi)[axis] += whole;
  setBox(window, box);
}

void cutPanel(WindowState& window) {
  const auto& dims = window.info().dims;
  constexpr std::array kNames{"x", "y", "z"};
  PictureOptions::Box box = boxOf(window);
  for (size_t a = 0; a < 3; ++a) {
    ImGui::PushID(static_cast<int>(a));
    ImGui::SetNextItemWidth(-1);
    if (dragInterval(box.lo[a], box.hi[a], dims[a], kNames[a])) setBox(window, box);
    window.log.control("crop " + std::string(kNames[a]));
    ImGui::PopID();
  }
  ImGui::BeginDisabled(!window.state().crop);
  if (ImGui::Button("no clip box")) setBox(window, {{0, 0, 0}, dims});
  window.log.control("no clip box");
  ImGui::EndDisabled();
  ImGui::SameLine();
  ImGui::BeginDisabled(window.state().crop.has_value());
  if (ImGui::Button("box with handles")) {
    for (size_t a = 0; a < 3; ++a) {
      box.lo[a] = dims[a] / 8;
      box.hi[a] = dims[a] - dims[a] / 8;
    }
    setBox(window, box);
  }
  window.log.control("box with handles");
  ImGui::EndDisabled();
  ImGui::SameLine();
  planes(window);
}

void drawBoxHandles(WindowState& window, const Area& area, float pixels) {
  const ViewState& shown = window.shown.picture.state;
  if (!shown.crop) return;
  ImDrawList& to = *ImGui::GetWindowDrawList();
  const auto screen = [&](const std::array<double, 3>& voxel) -> std::optional<ImVec2> {
    const auto at = paneOf(shown.view, worldOf(window, voxel), window.pane, window.volume.ground);
    if (!at) return std::nullopt;
    return ImVec2{area.x + static_cast<float>(at->x) / pixels,
                  area.y + static_cast<float>(at->y) / pixels};
  };
  const PictureOptions::Box box = *shown.crop;
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
  if (const auto at = screen(faceOf(box, 1))) window.log.control("handle x", at->x, at->y, 0, 0);
}

}  // namespace sluice
