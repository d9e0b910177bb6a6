// A path that was saved with a view, as frames: the way of the window's own (src/view), so that
// both write the same pictures.
#pragma once

#include <CLI/CLI.hpp>

#include <set>
#include <string>

#include "tools/options/render_arguments.h"
#include "tools/options/view_state_option.h"

namespace sluice {

// Whether the command asks for frames of the path rather than for one picture: its output has a
// place for numbers or --frames counts them, and no other option moves the camera or the time.
bool asksForFilm(const RenderArguments& arguments);

// Writes them: those of the path, or as many as --frames counts, at equal times from its beginning
// to its end. `given`: the options on the command line. Returns the exit status. Throws Error, also
// for an option that frames of a path do not take.
int writeFilm(const RenderArguments& arguments, const CLI::App& app, const SavedView& saved,
              const std::set<std::string>& given);

}  // namespace sluice
