#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "src/view/state/editing/transfer_edit.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

using namespace std::chrono_literals;

constexpr float kWheelFactor = 1.15F;
constexpr auto kHoverRests = 180ms;

using Does = Pointer::Does;

Does doesOf(const ImGuiIO& io) {
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Right)) return Does::kWindow;
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Middle)) return Does::kPan;
  if (!ImGui::IsMouseClicked(ImGuiMouseButton_Left)) return Does::kNothing;
  if (io.KeyShift) return Does::kPan;
  if (io.KeyCtrl) return Does::kRoll;
  if (io.KeyAlt) return Does::kLook;
  return Does::kOrbit;
}

void drag(WindowState& window, PanePoint by, float pixels) {
  const double dx = by.x * pixels, dy = by.y * pixels;
  const Pane pane = window.pane;
  const Ground& ground = window.volume.ground;
  using View = const ViewOptions&;
  switch (window.pointer.does) {
    case Does::kOrbit:
      return window.moveView([=](View view) { return orbit(view, dx, dy, pane); });
    case Does::kPan:
      return window.moveView([=](View view) { return pan(view, dx, dy, pane, ground); });
    case Does::kRoll:
      return window.moveView([=](View view) { return roll(view, -dx / 4); });
    case Does::kLook:
      return window.moveView([=](View view) { return lookAround(view, dx, dy, pane); });
    case Does::kWindow: {
      const auto all = window.valueRange();
      return window.edit([&](ViewState& next) {
        next.look.range =
            windowDragged(colorsOf(next.look, all), dx / pane.width, dy / pane.height, all);
      });
    }
    case Does::kHandle:
      return dragBoxHandle(window, window.pointer.handle, static_cast<float>(by.x),
                           static_cast<float>(by.y), pixels);
    case Does::kNothing:
      return;
  }
}

// Asks for the value under a pointer that rests on a complete picture.
void hover(WindowState& window, const Area& area) {
  Pointer& pointer = window.pointer;
  const ImVec2 at = ImGui::GetIO().MousePos;
  // A pointer that moves has no value: a probe may read blocks, and the hand is faster than the
  // disk.
  if (at.x != pointer.x || at.y != pointer.y) {
    pointer.x = at.x;
    pointer.y = at.y;
    pointer.still_since = WindowClock::now();
    window.pointer.value.reset();
    return;
  }
  if (pointer.still_since == WindowClock::time_point{}) return;  // asked already
  if (WindowClock::now() - pointer.still_since < kHoverRests) {
    window.loop.wakeBy(pointer.still_since + kHoverRests);
    return;
  }
  const ShownPicture& shown = window.shown.picture;
  const bool is_newest = shown.wish == window.wishes.number;
  if (!shown.is_complete || !is_newest) return;  // its news will wake us
  pointer.still_since = {};
  // A double click has asked for this place, and a second question would replace the first.
  if (window.pointer.centers) return;
  window.pointer.question =
      window.desk.probe((at.x - area.x) / area.width, (at.y - area.y) / area.height);
}

}  // namespace

void picturePane(WindowState& window, const Area& area, float pixels) {
  // Pixels are counted, which are smaller than screen units on dense screens.
  window.pane = {std::max(1, static_cast<int>(std::lround(area.width * pixels))),
                 std::max(1, static_cast<int>(std::lround(area.height * pixels)))};
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  // The pane is a window of ImGui, so that panels in front of it keep their own clicks. Without
  // padding and border, its pixels are the pixels of the picture.
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::Begin("picture", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar(2);
  const ImVec2 lo{area.x, area.y}, hi{area.x + area.width, area.y + area.height};
  const PictureOnScreen& shown = window.shown;
  if (shown.texture.id() != nullptr && window.isOpen()) {
    ImDrawList& to = *ImGui::GetWindowDrawList();
    const bool fades = shown.share < 1 && shown.before.id() != nullptr;
    // The coarser picture stays opaque under the finer one. If both were translucent, the
    // background would show through.
    if (fades) to.AddImage(shown.before.id(), lo, hi);
    const auto alpha = static_cast<int>(std::lround(255 * (fades ? shown.share : 1)));
    to.AddImage(shown.texture.id(), lo, hi, {0, 0}, {1, 1}, IM_COL32(255, 255, 255, alpha));
  }
  ImGui::SetCursorScreenPos(lo);
  // The button takes the clicks on the picture, so that a drag that leaves the pane goes on.
  ImGui::InvisibleButton("hand", {std::max(1.0F, area.width), std::max(1.0F, area.height)},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  window.log.control("picture");
  const ImGuiIO& io = ImGui::GetIO();
  Pointer& pointer = window.pointer;
  const bool is_over = ImGui::IsItemHovered();
  if (window.isOpen()) {
    // The point is centred when the answer comes (takeProbe()).
    if (is_over && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
      pointer.centers = true;
      pointer.question = window.desk.probe((io.MousePos.x - area.x) / area.width,
                                           (io.MousePos.y - area.y) / area.height);
      // The second press of a double click is no drag.
      pointer.does = Does::kNothing;
    } else if (ImGui::IsItemActivated()) {
      pointer.does = doesOf(io);
      // The handle is found at the press and kept, since the box moves away under a fast pointer.
      pointer.handle = boxHandleAt(window, area, pixels, io.MousePos.x, io.MousePos.y);
      if (pointer.handle >= 0 && pointer.does == Does::kOrbit) pointer.does = Does::kHandle;
    }
    if (ImGui::IsItemActive() && pointer.does != Does::kNothing) {
      // Each event of the pointer by itself: one sum of them would cut corners.
      for (const PanePoint& step : pointer.steps) drag(window, step, pixels);
    } else if (is_over && io.MouseWheel != 0) {
      window.moveView(
          [pane = window.pane, ground = window.volume.ground,
           factor = std::pow(kWheelFactor, io.MouseWheel),
           x = static_cast<double>((io.MousePos.x - area.x) * pixels),
           y = static_cast<double>((io.MousePos.y - area.y) * pixels)](const ViewOptions& view) {
            return zoomTo(view, factor, x, y, pane, ground);
          });
    } else if (is_over) {
      hover(window, area);
    } else {
      pointer.value.reset();
      pointer.x = pointer.y = -1;  // asks again when it comes back
    }
  }
  drawOverlays(window, area, pixels);
  ImGui::End();
}

}  // namespace sluice
