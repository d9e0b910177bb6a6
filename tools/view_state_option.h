// --state: a view that was saved, as options that the command line does not say.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace sluice {

// Adds what the file says to the options of a command that was parsed: each that the user did not
// give himself. A camera or a look of the user's, in any of its options, takes the place of all of
// the file's. Throws Error: the file, no volume in either place.
void applyState(CLI::App& app, const std::string& file);

}  // namespace sluice
