// A path that was saved with a view, as frames: the way of the window's own (src/view), so that
// both write the same pictures.
#pragma once

#include <CLI/CLI.hpp>

#include "tools/options/render_arguments.h"
#include "tools/options/view_state_option.h"

namespace sluice {

// Whether the command asks for the frames of the path rather than for one picture: its output has a
// place for numbers and no other option sets frames.
bool asksForFilm(const RenderArguments& arguments);

// Writes them; the exit status. Throws Error, also for an option that frames of a path do not take.
int writeFilm(const RenderArguments& arguments, const CLI::App& app, const SavedView& saved);

}  // namespace sluice
