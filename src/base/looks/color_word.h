// A word that may name a colour.
#pragma once

#include <algorithm>
#include <string_view>

namespace sluice {

// Whether the word is of letters, digits and hyphens, and not empty.
inline bool isColorWord(std::string_view word) {
  return !word.empty() && std::ranges::all_of(word, [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-';
  });
}

}  // namespace sluice
