#include "tests/support/wrong_states.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

namespace sluice {
namespace {

using nlohmann::json;

json right() {
  return json::parse(R"({
    "sluice": "view",
    "camera": {"projection": "perspective", "zoom": 1.5, "fov": 40, "eye": [0, 0, 90],
               "target": [12, 10, 8], "up": [0, 1, 0]},
    "look": {"mode": "composite", "light": "off",
             "opacities": [[10, 0], [90, 0.5]], "labels": false, "range": [0, 100],
             "full_gradient": 0.1},
    "time": 0, "step": 1, "crop": [1, 1, 1, 20, 18, 14], "clip": [[0, 0, 1, 12]],
    "background": [0, 0.5, 1], "cross": [3, 4, 5], "slices": true,
    "path": {"kind": "keys", "frames": 10, "rate": 25, "keys": [
      {"seconds": 1, "time": 0, "step": 1, "crop": [1, 1, 1, 20, 18, 14], "look": {"threshold": 40, "opacity": 0.5},
       "camera": {"eye": [0, 0, 90], "target": [12, 10, 8], "zoom": 1}},
      {"camera": {"eye": [90, 0, 0], "target": [12, 10, 8]}}]}
  })");
}

constexpr std::array<std::string_view, 4> kOfNoPosition{"/camera/view", "/camera/azimuth",
                                                        "/camera/elevation", "/camera/fit"};

// Adds the right view with `value` in place of the field's own.
class Table {
 public:
  void add(const std::string& field, const json& value) {
    json state = right();
    // A camera has a position or these, which are wrong beside one, whatever their values.
    if (std::ranges::find(kOfNoPosition, field) != kOfNoPosition.end())
      for (const char* place : {"eye", "target"}) state["camera"].erase(place);
    state[json::json_pointer(field)] = value;
    states.push_back({field, state.dump()});
  }
  void addEach(const std::string& field, const json& values) {
    for (const json& value : values) add(field, value);
  }
  // None of these is a number.
  void addTexts(const std::string& field) {
    addEach(field, {nullptr, "1", true, json::array(), json::object()});
  }
  void number(const std::string& field, const json& wrong) {
    addTexts(field);
    addEach(field, wrong);
  }
  // A list of `right` numbers, each of which in turn becomes each of `wrong`.
  void list(const std::string& field, const json& wrong) {
    const json given = right()[json::json_pointer(field)];
    addEach(field, {nullptr, 1, "text", json::array(), json::object()});
    json longer = given;
    longer.push_back(0);
    add(field, longer);
    for (size_t i = 0; i < given.size(); ++i)
      for (const json& value : wrong) {
        json spoilt = given;
        spoilt[i] = value;
        add(field, spoilt);
      }
  }

  std::vector<WrongState> states;
};

}  // namespace

std::string rightState() {
  return right().dump();
}

std::vector<WrongState> wrongStates() {
  Table table;
  table.number("/camera/zoom", {0, -1, 1e300});
  table.number("/camera/fov", {0, -1, 180, 1e300});
  table.number("/camera/azimuth", {1e6, -1e300});
  table.number("/camera/elevation", {1e6, -1e300});
  for (const char* place : {"/camera/eye", "/camera/target"}) table.list(place, {nullptr, 1e300});
  for (const std::string_view field : kOfNoPosition) {
    json state = right();
    state[json::json_pointer(std::string(field))] = 10;
    table.states.push_back({std::string(field), state.dump()});
  }
  table.add("/camera/eye", {12, 10, 8});  // on the target
  table.list("/camera/up", {"1", 1e300});
  table.addEach("/camera/up", {{0, 0, 0}, {-12, -10, 82}});  // none, along the view
  for (const char* word : {"/camera/projection", "/camera/view", "/camera/fit", "/look/mode",
                           "/look/light", "/path/kind"})
    table.addEach(word, {nullptr, 1, "no such", json::array(), ""});
  table.addTexts("/path/keys/0/look/threshold");
  table.addEach("/look/opacities", {1,
                                    "text",
                                    {1, 2},
                                    {{1, 2, 3}},
                                    {{1, -0.1}},
                                    {{1, 2}},
                                    {{5, 0}, {4, 0}},
                                    {{"1", 0}},
                                    {{1, nullptr}}});
  table.list("/look/range", {nullptr, "1"});
  table.add("/look/range", {42, 42});
  table.number("/look/full_gradient", {0, -1, 1e300});
  table.addEach("/look/labels", {nullptr, "yes", json::array(), json::object()});
  table.number("/time", {-1, 1, 5, 0.5, 1e30, INT64_MAX, INT64_MIN});
  table.number("/step", {0, -1, 1e300});
  table.list("/crop", {-1, 0.5, 100, INT64_MAX, INT64_MIN, "1"});
  table.addEach("/clip", {1,
                          "text",
                          {1, 2, 3, 4},
                          {{1, 2, 3}},
                          {{0, 0, 0, 1}},
                          {{0, 0, 1e300, 1}},
                          {{0, 0, 1, 1e300}},
                          {{0, 0, nullptr, 1}},
                          json(7, json{0, 0, 1, 12})});
  table.list("/background", {-0.1, 1.1, 1e300, "1"});
  table.list("/cross", {-1, 0.5, 100, INT64_MAX, INT64_MIN});
  table.addEach("/slices", {nullptr, "yes", json::array()});
  table.number("/path/frames", {0, -1, 0.5, 1e6, INT64_MAX});
  table.number("/path/rate", {0, -1, 1e300});
  table.addEach("/path/keys", {nullptr, 1, json::array(), json::object(), {1}, {nullptr}});
  table.number("/path/keys/0/seconds", {0, -1, 1e9, 1e300});
  table.number("/path/keys/0/time", {-1, 5, INT64_MAX});
  table.number("/path/keys/0/step", {0, -1});
  table.list("/path/keys/0/crop", {-1, 100});
  table.number("/path/keys/0/look/opacity", {-0.1, 1.1, 1e300});
  table.number("/path/keys/0/camera/zoom", {0, -1, 1e300});
  table.add("/path/keys/1/camera/eye", {12, 10, 8});
  return table.states;
}

}  // namespace sluice
