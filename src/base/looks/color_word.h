// Words for colours.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "src/base/values/vec.h"

namespace sluice {

// Whether the word is of letters, digits and hyphens, and not empty.
inline bool isColorWord(std::string_view word) {
  return !word.empty() && std::ranges::all_of(word, [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-';
  });
}

// "ff8800", the word for red, green and blue from 0 to 1.
std::string colorWord(std::span<const double> rgb);
// The colour of six hexadecimal digits, red first, with or without '#'; nullopt for other texts.
std::optional<Vec3d> hexColor(std::string_view text);

}  // namespace sluice
