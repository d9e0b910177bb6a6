// Parses words of the command line: sizes, triples, colours. Pure functions; each returns nullopt
// or throws Error for a malformed word, as its comment says.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/base/values/text_parts.h"
#include "src/base/values/vec.h"
#include "src/render/camera/camera.h"

namespace sluice {

// "256,256,128" (also with x between): exactly `count` numbers; nullopt otherwise.
std::optional<std::vector<double>> parseNumbers(const std::string& text, size_t count);
// The words between commas, each understood by `parse`; nullopt if one is not. An empty text has
// one empty word.
template <class Value, class Parse>
std::optional<std::vector<Value>> parseList(const std::string& text, Parse parse) {
  std::vector<Value> values;
  for (const std::string_view word : split(text, ',')) {
    std::optional<Value> value = parse(std::string(word));
    if (!value) return std::nullopt;
    values.push_back(*std::move(value));
  }
  return values;
}
// "512x512" or "512".
std::optional<PictureSize> parsePictureSize(const std::string& text);
// "RRGGBB" with an optional '#': 0..1 a channel.
std::optional<std::array<float, 3>> parseColor(const std::string& text);

// Requires: three numbers, whole ones for asVec3i().
Vec3d asVec3d(const std::vector<double>& numbers);
Vec3i asVec3i(const std::vector<double>& numbers);

}  // namespace sluice
