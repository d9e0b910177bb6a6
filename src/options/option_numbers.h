// The numbers within the values of options, by which films go from one key frame to the next.
// Derived from an option's kind alone, so that a new option needs nothing here. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/options/option_table.h"

namespace sluice {

// The numbers of a value in its own order; of a text such as a surface's, those that may change
// while it stays the same surface, label or channel. Words, names of files and flags have none.
struct OptionNumbers {
  std::vector<std::optional<double>> numbers = {};  // nullopt: a text does not set it
  std::vector<std::string> names = {};  // the labels or channels that the numbers belong to

  // Whether the two values may differ in their numbers alone.
  bool hasFormOf(const OptionNumbers& other) const {
    return numbers.size() == other.numbers.size() && names == other.names;
  }
};

OptionNumbers optionNumbers(const OptionKind& kind, const OptionValue& value);

// The value with these numbers in place of its own; nullopt keeps one. Whole numbers are rounded.
// Numbers that the option does not take together are changed: points stay in order, a box stays a
// voxel wide, and a range without a width or a plane without a direction keeps its own.
// Requires: as many numbers as optionNumbers() gives, each within the option's limits.
OptionValue withNumbers(const OptionKind& kind, OptionValue value,
                        const std::vector<std::optional<double>>& numbers);

}  // namespace sluice
