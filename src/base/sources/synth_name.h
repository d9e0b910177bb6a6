// How a volume that is computed, and read from no file, is told from a file by its name.
#pragma once

#include <string_view>

namespace sluice {

inline constexpr std::string_view kSynthPrefix = "synth:";

// Whether this names a synthetic volume rather than a file: starts with "synth:".
inline bool isSynthSpec(std::string_view text) {
  return text.starts_with(kSynthPrefix);
}

}  // namespace sluice
