#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

// A name and a button for its action.
bool named(WindowState& window, const char* id, const char* action, std::string& text) {
  ImGui::PushID(id);
  // A negative width leaves this much room to the right, for the button and its frame.
  ImGui::SetNextItemWidth(-ImGui::CalcTextSize(action).x - 30);
  ImGui::InputText("##name", &text);
  window.log.control(std::string(id) + " name");
  ImGui::SameLine();
  const bool is_done = ImGui::Button(action) && !text.empty();
  window.log.control(action);
  ImGui::PopID();
  return is_done;
}

}  // namespace

void filePanel(WindowState& window) {
  if (ImGui::Button("open...")) window.panels.shows_open = true;
  window.log.control("open");
  ImGui::SameLine();
  if (ImGui::Button("keys (?)")) window.panels.shows_help = true;
  // Nothing can be saved before there is a picture. A view that names its volume can be opened with
  // the dialog.
  if (!window.isOpen()) return;
  if (named(window, "picture", "save picture", window.panels.picture_file))
    savePicture(window, window.panels.picture_file);
  if (named(window, "state", "save view", window.panels.state_file))
    saveState(window, window.panels.state_file);
  if (ImGui::Button("load view")) loadState(window, window.panels.state_file);
  window.log.control("load view");
  for (const std::string& line : window.messages.lines) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextWrapped("%s", line.c_str());
    ImGui::PopStyleColor();
  }
}

void failuresWindow(WindowState& window) {
  if (window.messages.failures.empty()) return;
  ImGui::SetNextWindowPos({ImGui::GetMainViewport()->GetCenter().x, 40}, ImGuiCond_Always,
                          {0.5F, 0});
  ImGui::SetNextWindowSize({620, 0}, ImGuiCond_Always);
  bool stays = true;
  if (ImGui::Begin("that did not work", &stays,
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings))
    for (const std::string& line : window.messages.failures) ImGui::TextWrapped("%s", line.c_str());
  window.log.control("failure", ImGui::GetWindowPos().x, ImGui::GetWindowPos().y,
                     ImGui::GetWindowWidth(), ImGui::GetWindowHeight());
  ImGui::End();
  // The lines stay until the user has closed the window: a failure may come while nobody looks.
  if (!stays) window.messages.failures.clear();
}

}  // namespace sluice
