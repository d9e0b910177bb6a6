#include "src/view/state/files/settings.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/files/text_file.h"
#include "src/view/state/files/file_name_json.h"

namespace sluice {

Settings readSettings(const std::filesystem::path& path) {
  constexpr uint64_t kMostBytes = uint64_t{1} << 20;
  Settings settings;
  try {
    const std::string where = path.string();
    const nlohmann::json document =
        parseJson(readTextFile(path, kMostBytes, "a window's settings"), where);
    const JsonField root(document, where);
    // A size from a larger screen, or from a wrong hand, must not make a window that cannot be
    // used.
    const auto within = [](int64_t value) {
      return static_cast<int>(std::clamp<int64_t>(value, 320, 16384));
    };
    if (const auto f = root.find("width")) settings.width = within(f->whole());
    if (const auto f = root.find("height")) settings.height = within(f->whole());
    if (const auto f = root.find("font_scale"))
      settings.font_scale = std::clamp(f->number(), 0.5, 4.0);
    if (const auto f = root.find("recent"))
      for (size_t i = 0; i < std::min(f->size(), Settings::kMostRecent); ++i)
        settings.recent.push_back(fileNameOf((*f)[i]));
  } catch (const Error&) {  // NOLINT: it is not there, or of a hand that meant something else
  }
  return settings;
}

std::string settingsText(const Settings& settings) {
  nlohmann::json recent = nlohmann::json::array();
  for (const std::string& path : settings.recent) recent.push_back(fileNameJson(path));
  const nlohmann::json document = {{"width", settings.width},
                                   {"height", settings.height},
                                   {"font_scale", settings.font_scale},
                                   {"recent", recent}};
  return document.dump(2) + "\n";
}

void noteRecent(Settings& settings, const std::string& path) {
  // The newest is the first, and no volume is listed twice.
  std::erase(settings.recent, path);
  settings.recent.insert(settings.recent.begin(), path);
  if (settings.recent.size() > Settings::kMostRecent) settings.recent.resize(Settings::kMostRecent);
}

}  // namespace sluice
