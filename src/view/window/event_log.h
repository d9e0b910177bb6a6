// EventLog: what a window does, for who drives it: a JSON object a line. Where controls are (in
// screen units from the window's upper left corner, said again when they move), pictures that were
// shown, files saved, failures, and at the end what was measured. One thread.
#pragma once

#include <array>
#include <fstream>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sluice {

class EventLog {
 public:
  // Empty: nothing is written. Throws Error when the file cannot be.
  explicit EventLog(const std::string& path);

  bool isOn() const { return file_.is_open(); }
  void write(const nlohmann::json& line);
  // Of the item that ImGui was given last, or a rectangle of its own.
  void control(const std::string& name);
  void control(const std::string& name, float x, float y, float width, float height);

 private:
  std::ofstream file_;
  std::map<std::string, std::array<int, 4>> controls_;
};

}  // namespace sluice
