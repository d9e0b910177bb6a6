#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <optional>

#include "src/view/window/panels.h"

namespace sluice {
namespace {

constexpr double kLeastSeconds = 0.1, kMostSeconds = 600, kMostRate = 120;

void kinds(Sitting& sitting) {
  ViewPath& path = sitting.film;
  using Kind = ViewPath::Kind;
  if (ImGui::RadioButton("turntable", path.kind == Kind::kTurn)) path.kind = Kind::kTurn;
  sitting.log.control("turntable");
  ImGui::SameLine();
  if (ImGui::RadioButton("key frames", path.kind == Kind::kKeys)) path.kind = Kind::kKeys;
  sitting.log.control("key frames");
}

void turn(Sitting& sitting) {
  int frames = static_cast<int>(sitting.film.turn_frames);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderInt("##turn", &frames, 1, 720, "%d frames around",
                       ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp))
    sitting.film.turn_frames = frames;
  sitting.log.control("turn frames");
}

// A key frame's row; whether it is to be removed.
bool keyRow(Sitting& sitting, size_t number) {
  ViewKey& key = sitting.film.keys[number];
  const bool is_last = number + 1 == sitting.film.keys.size();
  ImGui::PushID(static_cast<int>(number));
  if (ImGui::Button(fmt::format("{}##go", number + 1).c_str())) {
    ViewState next = key.state;
    next.shows_slices = sitting.state().shows_slices;
    sitting.change(next);
  }
  sitting.log.control(fmt::format("key {}", number));
  ImGui::SameLine();
  const bool removes = ImGui::Button("x");
  sitting.log.control(fmt::format("remove key {}", number));
  ImGui::SameLine();
  if (ImGui::Button("take")) key.state = sitting.state();
  sitting.log.control(fmt::format("take key {}", number));
  if (!is_last) {
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    ImGui::DragScalar("##seconds", ImGuiDataType_Double, &key.seconds, 0.05F, &kLeastSeconds,
                      &kMostSeconds, "%.1f s to the next", ImGuiSliderFlags_AlwaysClamp);
    sitting.log.control(fmt::format("seconds {}", number));
  }
  ImGui::PopID();
  return removes;
}

void keyFrames(Sitting& sitting) {
  std::optional<size_t> removed;
  for (size_t i = 0; i < sitting.film.keys.size(); ++i)
    if (keyRow(sitting, i)) removed = i;
  if (removed) {
    sitting.endFilm();
    sitting.film.keys.erase(sitting.film.keys.begin() + static_cast<std::ptrdiff_t>(*removed));
  }
  if (ImGui::Button("add this view")) sitting.addKey();
  sitting.log.control("add view");
}

void preview(Sitting& sitting) {
  const int64_t frames = frameCount(sitting.film);
  if (frames == 0) return ImGui::TextDisabled("no key frames yet");
  if (ImGui::Button(sitting.is_film_playing ? "stop" : "play")) sitting.playFilm();
  sitting.log.control("play film");
  ImGui::SameLine();
  const int64_t first = 0, last = frames - 1;
  int64_t frame = std::min(sitting.film_from ? sitting.film_frame : 0, last);
  ImGui::SetNextItemWidth(sitting.film_from ? -60 : -1);
  if (ImGui::SliderScalar("##frame", ImGuiDataType_S64, &frame, &first, &last, "frame %lld",
                          ImGuiSliderFlags_AlwaysClamp)) {
    sitting.is_film_playing = false;
    sitting.showFrame(frame);
  }
  sitting.log.control("frame");
  if (!sitting.film_from) return;
  ImGui::SameLine();
  if (ImGui::Button("back")) sitting.endFilm();
  sitting.log.control("back");
}

void writing(Sitting& sitting) {
  const DeskStatus& status = sitting.status;
  const bool is_writing = status.frames > 0;
  const char* const action = is_writing ? "cancel" : "write frames";
  ImGui::SetNextItemWidth(-ImGui::CalcTextSize(action).x - 30);
  ImGui::InputText("##film", &sitting.film_text);
  sitting.log.control("film name");
  ImGui::SameLine();
  if (ImGui::Button(action)) sitting.writeFilm();
  sitting.log.control("write frames");
  if (!is_writing) return;
  const auto share = static_cast<float>(status.frames_written) / static_cast<float>(status.frames);
  ImGui::ProgressBar(share, {-1, 0},
                     fmt::format("{} of {} frames", status.frames_written, status.frames).c_str());
}

}  // namespace

void filmPanel(Sitting& sitting) {
  kinds(sitting);
  if (sitting.film.kind == ViewPath::Kind::kTurn)
    turn(sitting);
  else
    keyFrames(sitting);
  const double least = 1;
  ImGui::SetNextItemWidth(-1);
  ImGui::SliderScalar("##rate", ImGuiDataType_Double, &sitting.film.frames_per_second, &least,
                      &kMostRate, "%.0f frames a second", ImGuiSliderFlags_AlwaysClamp);
  sitting.log.control("frame rate");
  if (sitting.hasFilm())
    ImGui::TextDisabled(
        "%s", fmt::format("{} frames, {:.1f} s", frameCount(sitting.film), secondsOf(sitting.film))
                  .c_str());
  preview(sitting);
  writing(sitting);
}

}  // namespace sluice
