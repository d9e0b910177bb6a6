#include "src/view/window/event_log.h"

#include <imgui.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/base/error.h"

namespace sluice {

EventLog::EventLog(const std::string& path) {
  if (path.empty()) return;
  file_.open(path, std::ios::trunc);
  if (!file_.is_open()) failSystem("{}: the window's log cannot be written there", path);
  write({{"sluice", "log"}});  // by which the next run knows the file (FileKind)
}

void EventLog::write(const nlohmann::json& line) {
  if (!isOn()) return;
  file_ << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  file_.flush();
}

void EventLog::control(const std::string& name) {
  const ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
  control(name, lo.x, lo.y, hi.x - lo.x, hi.y - lo.y);
}

void EventLog::control(const std::string& name, float x, float y, float width, float height) {
  if (!isOn()) return;
  const auto whole = [](float value) { return static_cast<int>(std::lround(value)); };
  const std::array<int, 4> place{whole(x), whole(y), whole(width), whole(height)};
  const auto known = controls_.find(name);
  if (known != controls_.end() && known->second == place) return;
  controls_[name] = place;
  write({{"control", name}, {"at", place}});
}

}  // namespace sluice
