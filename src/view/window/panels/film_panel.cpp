#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

// The limits are those of a hand; a saved path may have others, which stay until the user moves the
// field.
constexpr float kLeastSeconds = 0.1F, kMostSeconds = 600, kLeastRate = 1, kMostRate = 120;

void kinds(WindowState& window) {
  ViewPath& path = window.film.path;
  using Kind = ViewPath::Kind;
  if (ImGui::RadioButton("turntable", path.kind == Kind::kTurn)) path.kind = Kind::kTurn;
  window.log.control("turntable");
  ImGui::SameLine();
  if (ImGui::RadioButton("key frames", path.kind == Kind::kKeys)) path.kind = Kind::kKeys;
  window.log.control("key frames");
}

void turn(WindowState& window) {
  // ViewPath::kMostFrames fits into an int.
  int frames = static_cast<int>(window.film.path.turn_frames);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderInt("##turn", &frames, 1, 720, "%d frames around",
                       ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    window.film.path.turn_frames = frames;
  window.log.control("turn frames");
}

// A key frame's row; whether it is to be removed.
bool keyRow(WindowState& window, size_t number) {
  ViewKey& key = window.film.path.keys[number];
  const bool is_last = number + 1 == window.film.path.keys.size();
  ImGui::PushID(static_cast<int>(number));
  if (ImGui::Button(fmt::format("{}##go", number + 1).c_str())) {
    window.afterFit([next = key.state](WindowState& fitted) mutable {
      // The slices belong to the window and not to the film, as in stateAt().
      next.shows_slices = fitted.state().shows_slices;
      fitted.change(next);
    });
  }
  window.log.control(fmt::format("key {}", number));
  ImGui::SameLine();
  const bool removes = ImGui::Button("x");
  window.log.control(fmt::format("remove key {}", number));
  ImGui::SameLine();
  if (ImGui::Button("take"))
    window.afterFit(
        [number](WindowState& fitted) {
          std::vector<ViewKey>& keys = fitted.film.path.keys;
          // The row may be gone when the view is fitted.
          if (number < keys.size()) keys[number].state = fitted.state();
        },
        fmt::format("key frame {} does not take the view", number + 1));
  window.log.control(fmt::format("take key {}", number));
  if (!is_last) {
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    auto seconds = static_cast<float>(key.seconds);
    if (ImGui::DragFloat("##seconds", &seconds, 0.05F, kLeastSeconds, kMostSeconds,
                         "%.1f s to the next", ImGuiSliderFlags_AlwaysClamp) &&
        // ImGui does not clamp NaN, which a user can type.
        std::isfinite(seconds))
      key.seconds = static_cast<double>(seconds);
    window.log.control(fmt::format("seconds {}", number));
  }
  ImGui::PopID();
  return removes;
}

void keyFrames(WindowState& window) {
  // The button lies above the list, which grows: it stays under the pointer.
  if (ImGui::Button("add this view")) addKey(window);
  window.log.control("add view");
  std::vector<ViewKey>& keys = window.film.path.keys;
  std::optional<size_t> removed;
  // While a removal waits, the rows have numbers that change with it.
  ImGui::BeginDisabled(window.film.removes_key);
  for (size_t i = 0; i < keys.size(); ++i)
    if (keyRow(window, i)) removed = i;
  ImGui::EndDisabled();
  if (!removed) return;
  window.film.removes_key = true;
  window.afterFit([number = *removed](WindowState& fitted) {
    fitted.film.removes_key = false;
    // A film that is shown would go on with frames of a path that is gone.
    endFilm(fitted);
    std::vector<ViewKey>& kept = fitted.film.path.keys;
    if (number < kept.size()) kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(number));
  });
}

void preview(WindowState& window) {
  const FilmEditor& film = window.film;
  const int64_t frames = std::max<int64_t>(1, frameCount(film.path));
  ImGui::BeginDisabled(frameCount(film.path) == 0);
  // The part behind ### is the identity of the button. Without it, a button whose label changes
  // under the pointer would lose its press.
  if (ImGui::Button(film.is_playing ? "stop###play" : "play###play")) playFilm(window);
  window.log.control("play film");
  ImGui::SameLine();
  const int64_t first = 0, last = frames - 1;
  int64_t frame = std::min(film.view ? film.frame : 0, last);
  ImGui::SetNextItemWidth(-60);
  if (ImGui::SliderScalar("##frame", ImGuiDataType_S64, &frame, &first, &last, "frame %lld",
                          ImGuiSliderFlags_AlwaysClamp)) {
    // The slider holds the frame that it was moved to, against the clock of a film that plays.
    window.film.is_playing = false;
    window.afterFit([frame](WindowState& fitted) { showFrame(fitted, frame); });
  }
  window.log.control("frame");
  ImGui::EndDisabled();
  ImGui::SameLine();
  ImGui::BeginDisabled(!film.view);
  if (ImGui::Button("back")) endFilm(window);
  window.log.control("back");
  ImGui::EndDisabled();
}

void writing(WindowState& window) {
  const DeskStatus& status = window.status;
  const bool is_writing = status.frames > 0;
  // The width of the longer of its two labels, so that nothing moves when writing begins.
  const float width = ImGui::CalcTextSize("write frames").x + 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SetNextItemWidth(-width - ImGui::GetStyle().ItemSpacing.x);
  ImGui::InputText("##film", &window.film.name);
  window.log.control("film name");
  ImGui::SameLine();
  if (ImGui::Button(is_writing ? "cancel###write" : "write frames###write", {width, 0}))
    writeFilm(window);
  window.log.control("write frames");
  const auto share = static_cast<float>(status.frames_written) /
                     static_cast<float>(std::max<int64_t>(1, status.frames));
  ImGui::ProgressBar(
      share, {-1, 0},
      is_writing ? fmt::format("{} of {} frames", status.frames_written, status.frames).c_str()
                 : "");
}

}  // namespace

void filmPanel(WindowState& window) {
  ViewPath& path = window.film.path;
  kinds(window);
  if (path.kind == ViewPath::Kind::kTurn)
    turn(window);
  else
    keyFrames(window);
  auto rate = static_cast<float>(path.frames_per_second);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##rate", &rate, kLeastRate, kMostRate, "%.0f frames a second",
                         ImGuiSliderFlags_AlwaysClamp) &&
      std::isfinite(rate))
    path.frames_per_second = static_cast<double>(rate);
  window.log.control("frame rate");
  ImGui::TextDisabled(
      "%s", fmt::format("{} frames, {:.1f} s", frameCount(path), secondsOf(path)).c_str());
  preview(window);
  writing(window);
}

}  // namespace sluice
