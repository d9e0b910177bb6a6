// LabelLook: how one or more labels of a segmentation look, as an option says it: `3=ff8800:0.4`.
// Pure functions.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace sluice {

struct LabelLook {
  // The labels from the first to the last; all of them if these are infinite.
  double first = -std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
  std::string color = {};  // the name of a colour, or six hexadecimal digits; empty: not changed
  std::optional<double> opacity = {};  // of a voxel length, 0 to 1; unset: not changed
  friend bool operator==(const LabelLook&, const LabelLook&) = default;
};

// "3=ff8800", "3=ff8800:0.4", "3=:0.4", "3-7=green", "all=:0"; nullopt: no such text. Labels are
// whole numbers. A colour is a word of letters, digits and hyphens; whether there is one of that
// name is not checked.
std::optional<LabelLook> parseLabelLook(std::string_view text);
// The text that gives the look again.
std::string labelLookText(const LabelLook& look);

}  // namespace sluice
