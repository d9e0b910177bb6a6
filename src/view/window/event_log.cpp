#include "src/view/window/event_log.h"

#include <imgui.h>

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/error.h"

namespace sluice {

EventLog::EventLog(const std::string& path) : path_(path) {
  if (path.empty()) return;
  file_.open(path, std::ios::trunc);
  if (!file_.is_open()) failSystem("{}: the window's log cannot be written there", path);
  write({{"sluice", "log"}});  // by which the next run knows the file (FileKind)
  if (const auto fault = takeFault()) failSystem("{}", *fault);
}

void EventLog::write(const nlohmann::json& line) {
  if (!isOn()) return;
  // Names of files need not be UTF-8, which JSON is. A replaced letter is better here than an
  // exception in the middle of a frame.
  file_ << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  // Tests read the log while the window runs, and a crash must not take the last lines with it.
  file_.flush();
  if (file_.good()) return;
  const int error = errno;
  fault_ = fmt::format("{}: the window's log cannot be written: {}", path_, std::strerror(error));
  // A full disk would fail again with each event. The fault is told once, and isOn() is false from
  // here on.
  file_.close();
}

std::optional<std::string> EventLog::takeFault() {
  return std::exchange(fault_, std::nullopt);
}

void EventLog::control(const std::string& name) {
  const ImVec2 lo = ImGui::GetItemRectMin(), hi = ImGui::GetItemRectMax();
  control(name, lo.x, lo.y, hi.x - lo.x, hi.y - lo.y);
}

void EventLog::control(const std::string& name, float x, float y, float width, float height) {
  if (!isOn()) return;
  const auto whole = [](float value) { return static_cast<int>(std::lround(value)); };
  const std::array<int, 4> place{whole(x), whole(y), whole(width), whole(height)};
  // Each frame reports all controls, and only those that moved are news.
  const auto known = controls_.find(name);
  if (known != controls_.end() && known->second == place) return;
  controls_[name] = place;
  write({{"control", name}, {"at", place}});
}

}  // namespace sluice
