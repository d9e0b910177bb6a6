// --state: a view that was saved, as options that the command line does not say.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

#include "src/view/view_path.h"

namespace sluice {

// A path that was saved with a view, and what of its key frames the user said himself: of those all
// frames have his.
struct SavedFilm {
  ViewPath path;
  bool has_camera = false, has_look = false, has_step = false, has_crop = false, has_clip = false;
  bool has_time = false, has_background = false;
};

// Adds what the file says to the options of a command that was parsed: each that the user did not
// give himself. A camera or a look of the user's, in any of its options, takes the place of all of
// the file's. The path in the file, if any. Throws Error: the file, no volume in either place.
std::optional<SavedFilm> applyState(CLI::App& app, const std::string& file);

}  // namespace sluice
