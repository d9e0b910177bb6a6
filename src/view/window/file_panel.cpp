#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "src/view/window/panels.h"

namespace sluice {
namespace {

// A name and what is done with it.
bool named(Sitting& sitting, const char* id, const char* action, std::string& text) {
  ImGui::PushID(id);
  ImGui::SetNextItemWidth(-ImGui::CalcTextSize(action).x - 30);
  ImGui::InputText("##name", &text);
  sitting.log.control(std::string(id) + " name");
  ImGui::SameLine();
  const bool is_done = ImGui::Button(action) && !text.empty();
  sitting.log.control(action);
  ImGui::PopID();
  return is_done;
}

}  // namespace

void filePanel(Sitting& sitting) {
  if (ImGui::Button("open...")) sitting.shows_open = true;
  sitting.log.control("open");
  ImGui::SameLine();
  if (ImGui::Button("keys (?)")) sitting.shows_help = true;
  if (!sitting.isOpen()) return;
  if (named(sitting, "picture", "save picture", sitting.picture_text))
    sitting.savePicture(sitting.picture_text);
  if (named(sitting, "state", "save view", sitting.state_text))
    sitting.saveState(sitting.state_text);
  if (ImGui::Button("load view")) sitting.desk.loadState(sitting.state_text);
  sitting.log.control("load view");
  for (const std::string& line : sitting.messages) {
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::TextWrapped("%s", line.c_str());
    ImGui::PopStyleColor();
  }
}

void failuresWindow(Sitting& sitting) {
  if (sitting.failures.empty()) return;
  ImGui::SetNextWindowPos({ImGui::GetMainViewport()->GetCenter().x, 40}, ImGuiCond_Always,
                          {0.5F, 0});
  ImGui::SetNextWindowSize({620, 0}, ImGuiCond_Always);
  bool stays = true;
  if (ImGui::Begin("that did not work", &stays,
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings))
    for (const std::string& line : sitting.failures) ImGui::TextWrapped("%s", line.c_str());
  sitting.log.control("failure", ImGui::GetWindowPos().x, ImGui::GetWindowPos().y,
                      ImGui::GetWindowWidth(), ImGui::GetWindowHeight());
  ImGui::End();
  if (!stays) sitting.failures.clear();
}

}  // namespace sluice
