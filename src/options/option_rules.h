// Tells which options of a picture go together, on the command line and as keywords of the Python
// package. Names are those of the command line.
#pragma once

#include <span>
#include <string_view>

namespace sluice {

struct OptionPair {
  std::string_view one, other;
};

// A picture takes one of the two.
std::span<const OptionPair> optionsApart();

// The first takes effect only with the second.
std::span<const OptionPair> optionNeeds();

}  // namespace sluice
