// Words of a command line that people paste into a shell. Pure functions.
#pragma once

#include <string>

namespace sluice {

// The word as sh reads it back: itself, or in single quotes where it must be.
std::string shellWord(const std::string& word);

}  // namespace sluice
