#include "src/view/window/window_state.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "src/base/files/file_kind.h"
#include "src/base/looks/view_limits.h"
#include "src/view/state/files/state_file.h"
#include "src/view/state/view_check.h"

namespace sluice {
namespace {

using namespace std::chrono_literals;

// Wheel and keys that follow each other so soon belong together.
constexpr auto kTogether = 600ms;
constexpr size_t kMostMessages = 6;

Wish wishOf(const WindowState& window) {
  return {.state = window.state(), .width = window.pane.width, .height = window.pane.height};
}

void saveStateNow(WindowState& window, const std::string& name) {
  const ViewPath& path = window.film.path;
  const bool has_film = path != ViewPath{} && frameCount(path) > 0;
  window.desk.saveText(
      name,
      // A frame of a film is no view of the user: the view behind it is saved.
      stateText(window.volume.news->volume, window.film.view.value_or(window.state()),
                has_film ? std::optional(path) : std::nullopt),
      FileKind::kView);
}

}  // namespace

WindowState::WindowState(const WindowRequest& given, const std::function<void()>& wake)
    : request(given),
      desk(*given.desk),
      log(given.log_file),
      settings(given.settings),
      dialog(wake) {}

void WindowState::change(const ViewState& next) {
  // Panels call this each frame that a control is active, most of them without a change.
  if (next == state()) return;
  // A value typed into a panel may be one that nothing can draw.
  if (const std::optional<ViewFault> fault = faultOf(next))
    return fail(fault->field + ": expected " + fault->expected + ", found " + fault->found +
                "; the view stays as it was");
  if (film.view) {
    // The way back leads to the view, not to a frame.
    history.replace(*std::exchange(film.view, std::nullopt));
    film.is_playing = false;
  }
  const auto now = WindowClock::now();
  // One step to undo for each gesture: a drag, or keys and wheel in a row.
  if (!pointer.is_down && now - loop.moved_at > kTogether) ++gesture;
  loop.moved_at = now;
  if (!pointer.is_down) loop.nudged_at = now;
  history.change(next, gesture);
}

void WindowState::say(const std::string& line) {
  messages.lines.push_front(line);
  // The panel has room for a few lines. Standard output keeps them all.
  if (messages.lines.size() > kMostMessages) messages.lines.pop_back();
  if (request.say) request.say(line);
}

void WindowState::fail(const std::string& line) {
  // A view that cannot be drawn fails again with each movement.
  if (std::ranges::find(messages.failures, line) == messages.failures.end())
    messages.failures.push_back(line);
  loop.wakeBy(WindowClock::now());  // a window of ImGui's shows in the frame after its first
  log.write({{"failure", line}});
}

void openAny(WindowState& window, const std::vector<std::string>& paths) {
  if (paths.empty()) return;
  // No reader of volumes takes .json, so that the ending alone tells a view from a volume.
  if (paths.size() == 1 && std::filesystem::path(paths.front()).extension() == ".json")
    loadState(window, paths.front());
  else
    window.desk.open({.paths = paths, .options = {}}, std::nullopt);
  window.panels.shows_open = false;
}

void loadState(WindowState& window, const std::string& name) {
  // A loaded view would otherwise be replaced by the fitted one that is still on its way.
  window.afterFit([name](WindowState& fitted) { fitted.desk.loadState(name); },
                  name + " is not loaded");
}

void savePicture(WindowState& window, const std::string& path) {
  if (!window.isOpen()) return;
  window.afterFit([path](WindowState& fitted) { fitted.desk.savePicture(path, wishOf(fitted)); },
                  path + " is not saved");
}

void saveState(WindowState& window, const std::string& name) {
  if (!window.isOpen()) return;
  window.afterFit([name](WindowState& fitted) { saveStateNow(fitted, name); },
                  name + " is not saved");
}

void showFrom(WindowState& window, ViewOptions::From from) {
  if (!window.isOpen()) return;
  // Saves that wait belong to the view that was asked for before, and so does a new projection.
  if (window.fit && !window.fit->waiting.empty())
    return window.afterFit([from](WindowState& fitted) { showFrom(fitted, from); });
  // A frame of a film is no view to start from, and the end of the film would replace the named
  // one.
  endFilm(window);
  ViewState next = window.state();
  const ViewOptions last = next.view;
  // Placed anew by the desk, so that the view fits what is visible.
  next.view = ViewOptions{};
  // Eye, target and zoom are left out, so that the desk computes all of them.
  next.view.from = from;
  next.view.projection = last.projection;
  next.view.field_of_view_deg = last.field_of_view_deg;
  window.fit = Fit{.number = window.desk.place(next, window.pane.width, window.pane.height),
                   .asked_at = WindowClock::now(),
                   .waiting = {}};
}

std::vector<std::string> dropFit(WindowState& window, const std::string& why) {
  std::vector<std::string> lines;
  if (!window.fit) return lines;
  for (const WaitingAct& dropped : window.fit->waiting)
    if (!dropped.loss.empty()) lines.push_back(dropped.loss + ": " + why);
  window.fit.reset();
  // The removal was among the waiting acts, and the rows of key frames are locked for as long as it
  // waits.
  window.film.removes_key = false;
  return lines;
}

void toggleProjection(WindowState& window) {
  if (!window.isOpen()) return;
  using Projection = ViewOptions::Projection;
  window.moveView([pane = window.pane, ground = window.volume.ground](const ViewOptions& view) {
    const bool is_perspective = view.projection == Projection::kPerspective;
    return withProjection(view, is_perspective ? Projection::kParallel : Projection::kPerspective,
                          pane, ground);
  });
}

void cutHere(WindowState& window) {
  window.afterFit([](WindowState& fitted) {
    ViewState next = fitted.state();
    // The limit is checked here again, since several acts may have waited for one fit.
    if (next.clip_planes.size() >= kMostAskedPlanes) return;
    const PlacedAxes axes = axesOf(next.view);
    const auto& target = next.view.look_at->target;
    next.clip_planes.push_back({{axes.back.x, axes.back.y, axes.back.z},
                                dot(axes.back, Vec3d{target[0], target[1], target[2]})});
    fitted.change(next);
  });
}

void undo(WindowState& window) {
  // Undo takes back the view that was asked for, not the one before, so it waits for the fit like a
  // move.
  window.afterFit([](WindowState& fitted) { fitted.history.undo(); });
}

void redo(WindowState& window) {
  window.afterFit([](WindowState& fitted) { fitted.history.redo(); });
}

}  // namespace sluice
