// Numbers in the names of files: the frames of a turntable, the time steps of a series, slices.
// Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace sluice {

constexpr bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

// The place of a run of digits in a name.
struct DigitRun {
  size_t at = 0, size = 0;
};
std::optional<DigitRun> lastDigits(std::string_view name);

// A name around the place of its number.
struct NumberedName {
  std::string before, after;
  size_t width = 0;  // digits at least, padded with zeros

  std::string with(int64_t number) const;
  // Whether with() gives `file` for some number >= 0.
  bool matches(std::string_view file) const;
};

// Parses a name with one number in it, as printf has it (%d, %04d, %i, %u; %% stands for %) or as
// '#' for each digit. nullopt: the name has no number, or more than one.
std::optional<NumberedName> parseNumberedName(std::string_view file);

// Whether the file's name has a place for a number, perhaps one that is not understood.
bool isNumbered(const std::filesystem::path& name);

// File number `number` of the name that a user gave. A pattern (parseNumberedName) takes the
// number. A name without one gets "_007" before its extension if `numbered`, and is the file itself
// otherwise. Throws Error when a pattern is not understood.
std::filesystem::path numberedName(const std::string& name, int64_t number, bool numbered);

}  // namespace sluice
