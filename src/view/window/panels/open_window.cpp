// The dialog that opens files. Folders are read on another thread; it shows the results.
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/values/letter_case.h"
#include "src/view/window/panels/panels.h"

namespace sluice {
namespace {

constexpr float kWidth = 640, kListHeight = 300;

bool holds(const std::string& name, const std::string& part) {
  return std::search(name.begin(), name.end(), part.begin(), part.end(),
                     [](char a, char b) { return lowercase(a) == lowercase(b); }) != name.end();
}

bool isPath(const std::string& typed) {
  return typed.find('/') != std::string::npos || typed.find(':') != std::string::npos;
}

void goTo(WindowState& window, std::string folder) {
  FolderDialog& dialog = window.dialog;
  FolderQuestion question{std::move(folder), window.request.volume_endings, dialog.joins_series};
  question.ends.emplace_back(".json");  // saved views
  // Entries of another folder must not appear under this one's name.
  if (question.folder != dialog.list.folder) dialog.list.entries.clear();
  dialog.list.failure.clear();
  dialog.asked = question;
  dialog.typed.clear();
  // A selection is an index into the list, which the answer replaces.
  dialog.selected = -1;
  dialog.reader.ask(question);
}

void take(WindowState& window) {
  FolderDialog& dialog = window.dialog;
  auto list = dialog.reader.take();
  if (!list) return;
  dialog.list = std::move(*list);
  dialog.selected = -1;
  window.log.write({{"folder", dialog.list.folder},
                    {"entries", dialog.list.entries.size()},
                    {"failure", dialog.list.failure}});
}

// The folder that is shown, or read to be.
std::string folderOf(const FolderDialog& dialog) {
  if (dialog.asked && !dialog.asked->folder.empty()) return dialog.asked->folder;
  return dialog.list.folder;
}

// Empty: it has none.
std::string parentOf(const FolderDialog& dialog) {
  const std::filesystem::path folder = folderOf(dialog);
  return folder.has_relative_path() ? folder.parent_path().string() : "";
}

// Opens the typed path or the entry, as a volume or a view.
void openIt(WindowState& window, const std::string& path) {
  // The field is empty when the dialog comes back, whatever becomes of the file.
  window.dialog.typed.clear();
  openAny(window, {path});
}

void enter(WindowState& window, const FolderEntry& entry) {
  if (entry.is_folder)
    goTo(window, entry.path);
  else
    openIt(window, entry.path);
}

// The path of what was typed: a path, or a name in the folder that is shown.
std::string typedPath(const FolderDialog& dialog) {
  if (isPath(dialog.typed) || dialog.list.folder.empty()) return dialog.typed;
  return (std::filesystem::path(dialog.list.folder) / dialog.typed).string();
}

std::vector<const FolderEntry*> shownEntries(const FolderDialog& dialog) {
  std::vector<const FolderEntry*> shown;
  // A path that is typed names one file and must not filter the list by its slashes.
  const bool filters = !dialog.typed.empty() && !isPath(dialog.typed);
  for (const FolderEntry& entry : dialog.list.entries)
    if (!filters || holds(entry.name, dialog.typed)) shown.push_back(&entry);
  return shown;
}

void keys(WindowState& window, const std::vector<const FolderEntry*>& shown) {
  FolderDialog& dialog = window.dialog;
  const int last = static_cast<int>(shown.size()) - 1;
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_DownArrow)))
    dialog.selected = std::min(dialog.selected + 1, last);
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_UpArrow)))
    dialog.selected = std::max(dialog.selected - 1, std::min(0, last));
  // Backspace belongs to the field as long as it has letters.
  const bool is_empty = dialog.typed.empty();
  if (is_empty && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Backspace)) &&
      !parentOf(dialog).empty())
    goTo(window, parentOf(dialog));
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) window.panels.shows_open = false;
}

void entries(WindowState& window, const std::vector<const FolderEntry*>& shown) {
  FolderDialog& dialog = window.dialog;
  if (!ImGui::BeginChild("entries", {0, kListHeight * ImGui::GetIO().FontGlobalScale}, true))
    return ImGui::EndChild();
  if (dialog.reader.isReading()) ImGui::TextDisabled("reading ...");
  if (!dialog.list.failure.empty())
    ImGui::TextWrapped("%s", dialog.list.failure.c_str());
  else if (shown.empty() && !dialog.reader.isReading())
    ImGui::TextDisabled("nothing here that is opened");
  const FolderEntry* chosen = nullptr;
  for (size_t i = 0; i < shown.size(); ++i) {
    const FolderEntry& entry = *shown[i];
    std::string label = entry.is_folder ? entry.name + "/" : entry.name;
    if (entry.files > 1) label += fmt::format("   ({} files)", entry.files);
    const bool is_selected = static_cast<int>(i) == dialog.selected;
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable(label.c_str(), is_selected)) chosen = &entry;
    ImGui::PopID();
    if (is_selected) ImGui::SetScrollHereY();
    window.log.control("entry " + entry.name);
  }
  ImGui::EndChild();
  // A copy, since going to a folder clears the list that the entry is in.
  if (chosen != nullptr) enter(window, FolderEntry(*chosen));
}

void recentOnes(WindowState& window) {
  if (window.settings.recent.empty()) return;
  ImGui::TextDisabled("recent");
  // A copy, since opening one changes the list.
  const std::vector<std::string> recent = window.settings.recent;
  for (size_t i = 0; i < recent.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::Selectable(recent[i].c_str())) openIt(window, recent[i]);
    ImGui::PopID();
    window.log.control(fmt::format("recent {}", i));
  }
}

// The name, and the buttons for it.
void nameLine(WindowState& window, const std::vector<const FolderEntry*>& shown) {
  FolderDialog& dialog = window.dialog;
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-70);
  const bool is_entered =
      ImGui::InputTextWithHint("##path", "a part of a name, a path, a pattern (step_%03d.nrrd)",
                               &dialog.typed, ImGuiInputTextFlags_EnterReturnsTrue);
  // The filter has changed, and with it what the index means.
  if (ImGui::IsItemEdited()) dialog.selected = -1;
  window.log.control("path");
  ImGui::SameLine();
  const bool opens = ImGui::Button("open");
  window.log.control("open it");
  const bool has_selected =
      dialog.selected >= 0 && static_cast<size_t>(dialog.selected) < shown.size();
  if (is_entered && has_selected)
    return enter(window, FolderEntry(*shown[static_cast<size_t>(dialog.selected)]));
  // If a single entry matches what was typed, it is meant.
  if (is_entered && shown.size() == 1 && !dialog.typed.empty() && !isPath(dialog.typed))
    return enter(window, FolderEntry(*shown.front()));
  if ((is_entered || opens) && !dialog.typed.empty()) return openIt(window, typedPath(dialog));
  if (opens && has_selected)
    openIt(window, std::string(shown[static_cast<size_t>(dialog.selected)]->path));
}

}  // namespace

void openWindow(WindowState& window) {
  // A window that was started without a volume begins with the dialog.
  if (!window.isOpen() && window.status.doing == DeskStatus::Doing::kNothing &&
      window.request.volume.paths.empty())
    window.panels.shows_open = true;
  FolderDialog& dialog = window.dialog;
  if (!window.panels.shows_open) {
    dialog.was_shown = false;
    return;
  }
  if (!std::exchange(dialog.was_shown, true)) goTo(window, dialog.list.folder);
  take(window);
  const float scale = ImGui::GetIO().FontGlobalScale;
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Appearing, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::min(kWidth * scale, ImGui::GetIO().DisplaySize.x), 0},
                           ImGuiCond_Appearing);
  if (ImGui::Begin("open a volume or a view", &window.panels.shows_open,
                   ImGuiWindowFlags_NoCollapse)) {
    const std::vector<const FolderEntry*> shown = shownEntries(dialog);
    keys(window, shown);
    ImGui::BeginDisabled(parentOf(dialog).empty());
    if (ImGui::Button("up")) goTo(window, parentOf(dialog));
    ImGui::EndDisabled();
    window.log.control("up");
    ImGui::SameLine();
    if (ImGui::Button("all slices of this folder")) openIt(window, folderOf(dialog));
    window.log.control("open folder");
    ImGui::SameLine();
    if (ImGui::Checkbox("series as one", &dialog.joins_series)) goTo(window, folderOf(dialog));
    window.log.control("series as one");
    ImGui::TextWrapped("%s", folderOf(dialog).c_str());
    // The entries are asked for again each time, since the lines above may have gone to another
    // folder.
    nameLine(window, shownEntries(dialog));
    entries(window, shownEntries(dialog));
    recentOnes(window);
  }
  ImGui::End();
}

}  // namespace sluice
