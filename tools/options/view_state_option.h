// --state: a saved view, as options that the command line lacks.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/options/option_table.h"
#include "src/view/state/files/state_file.h"
#include "src/view/state/view_path.h"

namespace sluice {

// A path saved with a view, and the options that the user gave: all frames have these from the
// user.
struct SavedFilm {
  ViewPath path;
  std::vector<const OptionEntry*> given;  // entries of optionTable()
};

// A saved view, without the properties that the user gave.
struct SavedView {
  StateFile file;
  std::optional<SavedFilm> film;                 // set if the file has a path
  std::string name;                              // the file's name
  std::vector<std::string> volume_options = {};  // of the volume, taken from the file

  // Parts of the view that no picture shows, one line each.
  std::vector<std::string> notes() const;
  // Whether the error speaks of an option that the file has and the user did not give.
  bool isToBlame(const Error& error) const;
  // Throws Error, which names the file, when it does not fit the volume.
  void requireFits(const VolumeInfo& volume) const;
};

// Whether the option is one of the ways to give opacities, of which one takes the place of the
// others.
bool givesOpacities(const OptionEntry& entry);

// Adds the file's values to the options of a command that was parsed: each one that the user did
// not give. A camera of the user's, in any of its options, takes the place of the file's, and so
// does a way to give opacities. `asked`: the view that the command line asks for. Throws Error: the
// file, no volume in either place, a value of the file or of the user that has no effect beside the
// other's.
SavedView applyState(CLI::App& app, const std::string& file, const ViewState& asked);

}  // namespace sluice
