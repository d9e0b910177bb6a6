// From a view or a volume to options as a command line takes them, by the table of options. Pure
// functions.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "src/options/option_table.h"
#include "src/options/view_state.h"

namespace sluice {

// An option and its value; of a flag that is empty.
using OptionWord = std::pair<std::string, std::string>;

// The options that the view sets, of the entries that `takes` selects and that count in the view
// (OptionEntry::is_printed), in ascending order of turns.
std::vector<OptionWord> optionWords(const ViewState& state,
                                    const std::function<bool(const OptionEntry&)>& takes);
// The options of a volume (--dims, --type, ...) that are set, in the table's order.
std::vector<OptionWord> volumeWords(const VolumeOptions& options);
// The light and the sampling (OptionEntry::is_light).
std::vector<OptionWord> lightWords(const ViewState& state);

// " --light=60,20 --no-shade": a blank in front of each, quoted for a shell if necessary, and an
// option and its value as a single word, so that a value may begin with a minus.
std::string optionsText(const std::vector<OptionWord>& words);

}  // namespace sluice
