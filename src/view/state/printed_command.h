// From a view to the command line that draws it: `sluice render` with all options needed. Pure
// functions.
#pragma once

#include <sluice/report.h>

#include <string>
#include <vector>

#include "src/options/option_words.h"
#include "src/options/view_state.h"

namespace sluice {

// The look as it was asked for.
std::vector<OptionWord> lookWords(const LookOptions& look);
// Camera, step, crop, clip planes, time and background.
std::vector<OptionWord> pictureWords(const ViewState& state);

// "sluice render head.nrrd --threshold 40 ... --size 800x600 -o head.png", words quoted for a shell
// if they must be. A volume that was opened soon is drawn from its levels. `look`: the options that
// give the look as it is drawn (ShownLook::options); empty: as it was asked for.
std::string renderCommand(const ViewedVolume& volume, const ViewState& state,
                          const std::string& look, int width, int height,
                          const std::string& output);
// The frames of the path in the file of a state.
std::string framesCommand(const std::string& state_file, int width, int height,
                          const std::string& output);

}  // namespace sluice
