// The window's own panel: its sections, one below the other.
#include <fmt/format.h>
#include <imgui.h>

#include <filesystem>
#include <string>

#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

// The file's name; a grid's stands behind that of its file.
std::string titleOf(const WindowState& window) {
  const std::string& name = window.info().name;
  const std::filesystem::path path = window.volume.news->volume.paths.front();
  return path.extension() == ".vdb" ? path.filename().string() + " " + name : name;
}

void section(WindowState& window, const char* name, bool is_open, void (*panel)(WindowState&)) {
  ImGui::SetNextItemOpen(is_open, ImGuiCond_Once);
  const bool shown = ImGui::CollapsingHeader(name);
  window.log.control(std::string("section ") + name);
  if (!shown) return;
  // Sections have items of the same names, such as "##opacity", which must differ for ImGui.
  ImGui::PushID(name);
  panel(window);
  ImGui::PopID();
}

}  // namespace

void sidePanel(WindowState& window, const Area& area) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_AlwaysVerticalScrollbar);  // nothing moves when it comes
  if (window.isOpen()) {
    const VolumeInfo& info = window.info();
    ImGui::TextDisabled("%s", fmt::format("{}: {} x {} x {} {}, {}", titleOf(window), info.dims[0],
                                          info.dims[1], info.dims[2], info.type,
                                          window.volume.news->device.substr(
                                              0, window.volume.news->device.find(',')))
                                  .c_str());
    section(window, "look", true, lookPanel);
    const bool has_channels = !window.volume.look.channels.empty();
    if (has_channels) section(window, "channels", true, channelsPanel);
    if (!window.state().look.surfaces.empty()) section(window, "surfaces", true, surfacesPanel);
    section(window, "opacity over values", !has_channels, transferPanel);
    if (info.time_steps > 1) section(window, "time", true, timePanel);
    section(window, "view", true, viewPanel);
    section(window, "cut", false, cutPanel);
    section(window, "film", false, filmPanel);
    section(window, "levels of memory", false, levelsPanel);
  }
  section(window, "files", true, filePanel);
  ImGui::End();
}

}  // namespace sluice
