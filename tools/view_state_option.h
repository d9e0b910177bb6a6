// --state: a view that was saved, as options that the command line does not say.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

#include "src/view/state/state_file.h"
#include "src/view/state/view_path.h"

namespace sluice {

// A path that was saved with a view, and what of its key frames the user said himself: of those all
// frames have his.
struct SavedFilm {
  ViewPath path;
  bool has_camera = false, has_look = false, has_step = false, has_crop = false, has_clip = false;
  bool has_time = false, has_background = false;
};

// A view that was saved, less what the user gave himself.
struct SavedView {
  StateFile file;
  std::optional<SavedFilm> film;  // where the file has a path
  std::string name;               // of the file

  // Throws Error, which names the file, when it does not fit the volume.
  void requireFits(const VolumeInfo& volume) const;
};

// Adds what the file says to the options of a command that was parsed: each that the user did not
// give himself. A camera or a look of the user's, in any of its options, takes the place of all of
// the file's. Throws Error: the file, no volume in either place.
SavedView applyState(CLI::App& app, const std::string& file);

}  // namespace sluice
