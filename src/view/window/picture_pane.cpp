#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "src/view/transfer_edit.h"
#include "src/view/window/panels.h"

namespace sluice {
namespace {

using namespace std::chrono_literals;

constexpr float kWheelFactor = 1.15F;
constexpr auto kHoverRests = 180ms;

using Does = Hand::Does;

Does doesOf(const ImGuiIO& io) {
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Right)) return Does::kWindow;
  if (ImGui::IsMouseClicked(ImGuiMouseButton_Middle)) return Does::kPan;
  if (!ImGui::IsMouseClicked(ImGuiMouseButton_Left)) return Does::kNothing;
  if (io.KeyShift) return Does::kPan;
  if (io.KeyCtrl) return Does::kRoll;
  if (io.KeyAlt) return Does::kLook;
  return Does::kOrbit;
}

void drag(Sitting& sitting, ImVec2 by, float pixels) {
  const double dx = static_cast<double>(by.x) * pixels, dy = static_cast<double>(by.y) * pixels;
  ViewState next = sitting.state();
  switch (sitting.hand.does) {
    case Does::kOrbit:
      next.view = orbit(next.view, dx, dy, sitting.pane);
      break;
    case Does::kPan:
      next.view = pan(next.view, dx, dy, sitting.pane, sitting.ground);
      break;
    case Does::kRoll:
      next.view = roll(next.view, -dx / 4);
      break;
    case Does::kLook:
      next.view = lookAround(next.view, dx, dy, sitting.pane);
      break;
    case Does::kWindow: {
      const auto all = sitting.valueRange();
      next.look.range = windowDragged(next.look.range.value_or(all), dx / sitting.pane.width,
                                      dy / sitting.pane.height, all);
      break;
    }
    case Does::kHandle:
      return dragBoxHandle(sitting, sitting.hand.handle, by.x, by.y, pixels);
    case Does::kNothing:
      return;
  }
  sitting.change(next);
}

// Asks for what is under a pointer that rests on a picture that is whole.
void hover(Sitting& sitting, const Area& area) {
  Hand& hand = sitting.hand;
  const ImVec2 at = ImGui::GetIO().MousePos;
  if (at.x != hand.x || at.y != hand.y) {
    hand.x = at.x;
    hand.y = at.y;
    hand.still_since = WindowClock::now();
    sitting.hovered.reset();
    return;
  }
  if (hand.still_since == WindowClock::time_point{}) return;  // asked already
  if (WindowClock::now() - hand.still_since < kHoverRests) {
    sitting.wakeBy(hand.still_since + kHoverRests);
    return;
  }
  if (!sitting.picture.is_complete) return;  // its news will wake us
  hand.still_since = {};
  if (sitting.centers_on_probe) return;
  sitting.probe_number =
      sitting.desk.probe((at.x - area.x) / area.width, (at.y - area.y) / area.height);
}

}  // namespace

void picturePane(Sitting& sitting, const Area& area, float pixels) {
  sitting.pane = {std::max(1, static_cast<int>(std::lround(area.width * pixels))),
                  std::max(1, static_cast<int>(std::lround(area.height * pixels)))};
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0);
  ImGui::Begin("picture", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PopStyleVar(2);
  const ImVec2 lo{area.x, area.y}, hi{area.x + area.width, area.y + area.height};
  if (sitting.texture.id() != nullptr && sitting.isOpen())
    ImGui::GetWindowDrawList()->AddImage(sitting.texture.id(), lo, hi);
  ImGui::SetCursorScreenPos(lo);
  ImGui::InvisibleButton("hand", {std::max(1.0F, area.width), std::max(1.0F, area.height)},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  sitting.log.control("picture");
  const ImGuiIO& io = ImGui::GetIO();
  Hand& hand = sitting.hand;
  const bool is_over = ImGui::IsItemHovered();
  if (sitting.isOpen()) {
    if (is_over && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
      sitting.centers_on_probe = true;
      sitting.probe_number = sitting.desk.probe((io.MousePos.x - area.x) / area.width,
                                                (io.MousePos.y - area.y) / area.height);
      hand.does = Does::kNothing;
    } else if (ImGui::IsItemActivated()) {
      hand.does = doesOf(io);
      hand.handle = boxHandleAt(sitting, area, pixels, io.MousePos.x, io.MousePos.y);
      if (hand.handle >= 0 && hand.does == Does::kOrbit) hand.does = Does::kHandle;
    }
    if (ImGui::IsItemActive() && hand.does != Does::kNothing) {
      if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0) drag(sitting, io.MouseDelta, pixels);
    } else if (is_over && io.MouseWheel != 0) {
      ViewState next = sitting.state();
      next.view = zoomTo(next.view, std::pow(kWheelFactor, io.MouseWheel),
                         static_cast<double>((io.MousePos.x - area.x) * pixels),
                         static_cast<double>((io.MousePos.y - area.y) * pixels), sitting.pane,
                         sitting.ground);
      sitting.change(next);
    } else if (is_over) {
      hover(sitting, area);
    }
  }
  drawOverlays(sitting, area, pixels);
  ImGui::End();
}

}  // namespace sluice
