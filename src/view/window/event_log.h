// EventLog: a window's events for a program that drives it, a JSON object a line. It records where
// controls are (in screen units from the window's upper left corner, again whenever they move),
// pictures that were shown, files saved, failures, and the measurements at the end. One thread.
#pragma once

#include <array>
#include <fstream>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace sluice {

class EventLog {
 public:
  // Empty: nothing is written. Throws Error when the file cannot be.
  explicit EventLog(const std::string& path);

  bool isOn() const { return file_.is_open(); }
  // A line for an event, written at once. Nothing if the log is off.
  void write(const nlohmann::json& line);
  // The message of the write that failed, once; after it, nothing is written.
  std::optional<std::string> takeFault();
  // Logs the place of ImGui's last item, or of a given rectangle.
  void control(const std::string& name);
  void control(const std::string& name, float x, float y, float width, float height);

 private:
  std::string path_;
  std::ofstream file_;
  std::optional<std::string> fault_;
  std::map<std::string, std::array<int, 4>> controls_;
};

}  // namespace sluice
