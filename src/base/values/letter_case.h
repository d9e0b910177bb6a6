// Lower case of ASCII letters. The bytes of other characters stay as they are.
#pragma once

#include <string>
#include <string_view>

namespace sluice {

inline char lowercase(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

inline std::string lowercase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = lowercase(c);
  return lower;
}

}  // namespace sluice
