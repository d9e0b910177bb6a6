#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "src/options/option_table.h"
#include "src/view/state/editing/transfer_edit.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

constexpr double kTurn = 24;  // pixels of a drag that an arrow stands for, of a pane of 800
constexpr double kFlight = 0.04;

// Keys that are held repeat, so that an arrow goes on turning.
bool pressed(int key) {
  return ImGui::IsKeyPressed(key);
}

void files(WindowState& window, const ImGuiIO& io) {
  if (pressed(GLFW_KEY_Z)) {
    if (io.KeyShift)
      redo(window);
    else
      undo(window);
  }
  if (pressed(GLFW_KEY_Y)) redo(window);
  if (pressed(GLFW_KEY_O)) window.panels.shows_open = true;
  if (pressed(GLFW_KEY_S)) {
    if (io.KeyShift)
      saveState(window, window.panels.state_file);
    else
      savePicture(window, window.panels.picture_file);
  }
  if (pressed(GLFW_KEY_F)) writeFilm(window);
  // The loop ends after this turn, so that the settings and the log are still written.
  if (pressed(GLFW_KEY_Q)) window.wants_to_end = true;
  if (pressed(GLFW_KEY_EQUAL) || pressed(GLFW_KEY_KP_ADD)) window.settings.font_scale *= 1.1;
  if (pressed(GLFW_KEY_MINUS) || pressed(GLFW_KEY_KP_SUBTRACT)) window.settings.font_scale /= 1.1;
  // The settings file has the same limits: a font that cannot be read would be there again at the
  // next start.
  window.settings.font_scale = std::clamp(window.settings.font_scale, 0.5, 4.0);
}

void camera(WindowState& window, const ImGuiIO& io) {
  const Pane pane = window.pane;
  const Ground ground = window.volume.ground;
  // An arrow turns by the same angle in a pane of any size, since a drag is measured by the pane.
  const double turn = kTurn * std::min(pane.width, pane.height) / 800;
  const auto held = [&](int key, auto&& move) {
    if (pressed(key)) window.moveView(move);
  };
  held(GLFW_KEY_LEFT, [=](const ViewOptions& v) { return orbit(v, -turn, 0, pane); });
  held(GLFW_KEY_RIGHT, [=](const ViewOptions& v) { return orbit(v, turn, 0, pane); });
  held(GLFW_KEY_UP, [=](const ViewOptions& v) { return orbit(v, 0, -turn, pane); });
  held(GLFW_KEY_DOWN, [=](const ViewOptions& v) { return orbit(v, 0, turn, pane); });
  const auto flight = [&](double ahead, double right, double up) {
    return [=](const ViewOptions& v) { return fly(v, ahead, right, up, ground); };
  };
  held(GLFW_KEY_W, flight(kFlight, 0, 0));
  held(GLFW_KEY_S, flight(-kFlight, 0, 0));
  held(GLFW_KEY_A, flight(0, -kFlight, 0));
  held(GLFW_KEY_D, flight(0, kFlight, 0));
  held(GLFW_KEY_PAGE_UP, flight(0, 0, kFlight));
  held(GLFW_KEY_PAGE_DOWN, flight(0, 0, -kFlight));
  held(GLFW_KEY_Q, [](const ViewOptions& v) { return roll(v, -5); });
  held(GLFW_KEY_E, [](const ViewOptions& v) { return roll(v, 5); });
  const auto zoom = [&](double factor) {
    window.moveView([=](const ViewOptions& v) {
      return zoomTo(v, factor, pane.width / 2.0, pane.height / 2.0, pane, ground);
    });
  };
  if (pressed(GLFW_KEY_EQUAL) || pressed(GLFW_KEY_KP_ADD)) zoom(1.1);
  if (pressed(GLFW_KEY_MINUS) || pressed(GLFW_KEY_KP_SUBTRACT)) zoom(1 / 1.1);
  if (pressed(GLFW_KEY_P)) toggleProjection(window);
  constexpr std::array kFrom{ViewOptions::From::kThreeQuarter, ViewOptions::From::kFront,
                             ViewOptions::From::kBack,         ViewOptions::From::kLeft,
                             ViewOptions::From::kRight,        ViewOptions::From::kTop,
                             ViewOptions::From::kBottom};
  for (size_t i = 0; i < kFrom.size(); ++i)
    if (pressed(GLFW_KEY_0 + static_cast<int>(i)) && !io.KeyShift) showFrom(window, kFrom[i]);
}

void look(WindowState& window, const ImGuiIO& io) {
  ViewState next = window.state();
  const auto all = window.valueRange();
  if (pressed(GLFW_KEY_T)) {
    const double now = next.look.threshold.value_or(all[0] + (all[1] - all[0]) / 5);
    const double by = (io.KeyShift ? -0.01 : 0.01) * (all[1] - all[0]);
    next.look = withThreshold(next.look, std::clamp(now + by, all[0], all[1]));
  }
  // The table of options has the modes, so that a new one joins the round by itself.
  const auto modes = static_cast<int>(optionEntry("--mode").kind.words.size());
  if (pressed(GLFW_KEY_M))
    next.look.mode = static_cast<LookOptions::Mode>((static_cast<int>(next.look.mode) + 1) % modes);
  if (pressed(GLFW_KEY_L))
    // A look without the option may be lit or not, so the key goes by what the picture shows.
    next.look.light = window.volume.look.lit ? LookOptions::Light::kOff : LookOptions::Light::kOn;
  if (pressed(GLFW_KEY_G))
    next.look.full_gradient = next.look.full_gradient ? std::nullopt : std::optional<double>(0.1);
  if (pressed(GLFW_KEY_B)) {
    using Color = std::array<float, 3>;
    if (!next.background)
      next.background = Color{0, 0, 0};
    else if ((*next.background)[0] < 0.5F)
      next.background = Color{1, 1, 1};
    else
      next.background.reset();
  }
  const auto step = [&](double factor) {
    next.step_vox = std::clamp(next.step_vox.value_or(1) * factor, 0.1, 8.0);
  };
  if (pressed(GLFW_KEY_LEFT_BRACKET)) step(0.8);
  if (pressed(GLFW_KEY_RIGHT_BRACKET)) step(1.25);
  if (pressed(GLFW_KEY_X)) {
    if (next.crop) {
      next.crop.reset();
    } else {
      PictureOptions::Box box{};
      const auto& dims = window.info().dims;
      for (size_t a = 0; a < 3; ++a) {
        box.lo[a] = dims[a] / 8;
        box.hi[a] = std::max(box.lo[a] + std::min<int64_t>(2, dims[a]), dims[a] - dims[a] / 8);
      }
      next.crop = box;
    }
  }
  if (pressed(GLFW_KEY_V)) next.shows_slices = !next.shows_slices;
  // One change for all keys of a frame is one step of undo. A cut waits for a fit and so makes its
  // own.
  window.change(next);
  if (pressed(GLFW_KEY_C)) cutHere(window);
}

void series(WindowState& window) {
  const int64_t steps = window.info().time_steps;
  if (steps < 2) return;
  if (pressed(GLFW_KEY_SPACE)) window.series.is_playing = !window.series.is_playing;
  ViewState next = window.state();
  if (pressed(GLFW_KEY_COMMA)) next.time = (next.time + steps - 1) % steps;
  if (pressed(GLFW_KEY_PERIOD)) next.time = (next.time + 1) % steps;
  // Steps of a series are no steps to undo: the way back would lead through all that were played.
  if (next.time != window.state().time) window.history.replace(next);
}

void film(WindowState& window, const ImGuiIO& io) {
  if (pressed(GLFW_KEY_F)) playFilm(window);
  if (!pressed(GLFW_KEY_K)) return;
  if (!io.KeyShift) return addKey(window);
  window.afterFit([](WindowState& fitted) {
    // A frame that is shown belongs to the path with the key that goes.
    endFilm(fitted);
    if (!fitted.film.path.keys.empty()) fitted.film.path.keys.pop_back();
  });
}

}  // namespace

void takeKeys(WindowState& window) {
  const ImGuiIO& io = ImGui::GetIO();
  // Letters that are typed into a field are no commands.
  if (io.WantTextInput) return;
  // Takes '?' as the keyboard layout has it: Shift and slash on many, a key of its own on others.
  for (const ImWchar typed : io.InputQueueCharacters)
    if (typed == '?') window.panels.shows_help = !window.panels.shows_help;
  if (pressed(GLFW_KEY_ESCAPE)) {
    window.panels.shows_help = window.panels.shows_open = false;
    endFilm(window);
    window.messages.failures.clear();
  }
  if (io.KeyCtrl) return files(window, io);
  // The dialog has keys of its own, and a volume that it opens may replace the open one.
  if (!window.isOpen() || window.panels.shows_open) return;
  camera(window, io);
  look(window, io);
  series(window);
  film(window, io);
  if (pressed(GLFW_KEY_N)) window.panels.shows_maps = !window.panels.shows_maps;
  if (pressed(GLFW_KEY_H)) window.panels.is_log_histogram = !window.panels.is_log_histogram;
  if (pressed(GLFW_KEY_O)) window.panels.shows_axes = !window.panels.shows_axes;
}

}  // namespace sluice
