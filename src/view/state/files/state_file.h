// A view in a file: JSON, for the window and for `sluice render --state`.
//
//   {"sluice": "view", "volume": {"paths": ["head.nrrd"]}, "camera": {"eye": [0, 0, 500], ...},
//    "look": {"threshold": 40, "map": "ct-bone", "range": [0, 255]}, "crop": [0, 0, 0, 64, 64, 64],
//    "path": {"kind": "keys", "rate": 25, "keys": [{"seconds": 2, "camera": {...}}, {...}]}}
//
// Every field but "sluice" may be left out; numbers mean the same as in the options of the same
// names. Values that have no effect beside the others are refused, and saved views have none.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "src/base/threads/stop_token.h"
#include "src/options/view_state.h"
#include "src/view/state/view_path.h"

namespace sluice {

struct StateFile {
  std::optional<ViewedVolume> volume;
  ViewState state;
  std::optional<ViewPath> path;  // path of a film that starts from it
};

// Names of files that are there become absolute, so that the state may be read elsewhere.
std::string stateText(const ViewedVolume& volume, const ViewState& state,
                      const std::optional<ViewPath>& path = {});
// Throws Error, starting with `where`: the field, the expected and the found value.
StateFile parseState(std::string_view json, const std::string& where);

// The place of an option in a view: "/look/mode"; for a flag with its word: "/look/light off".
std::string placeOf(std::string_view option);
// Throws Error, starting with `where`, for a value of the view that has no effect beside the others
// (src/options/option_rules.h). `nameOf`: the place of an option, or what else the message calls
// it.
void requireNoConflict(const ViewState& state, const std::string& where,
                       const std::function<std::string(std::string_view option)>& nameOf);

// Throws Error, and Interrupted while it waits for a pipe.
StateFile readState(const std::filesystem::path& path, const StopToken& stop = {});

}  // namespace sluice
