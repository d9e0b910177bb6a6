// Settings: the values that a window keeps between runs: its size, its font's size, and the volumes
// that were open last. A small JSON file in a folder that the program names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sluice {

struct Settings {
  int width = 1180, height = 760;  // size of the window, screen units
  double font_scale = 1;
  std::vector<std::string> recent;  // paths, the last one first

  static constexpr size_t kMostRecent = 12;
};

// Reads the settings that the file has. Defaults apply if the file is missing or holds something
// else, so that a window opens anyway.
Settings readSettings(const std::filesystem::path& path);
std::string settingsText(const Settings& settings);
// Moves the path to the front.
void noteRecent(Settings& settings, const std::string& path);

}  // namespace sluice
