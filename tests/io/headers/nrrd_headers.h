// NRRD headers as the tests of their fields and of whole files begin with.
#pragma once

#include <string>

#include "src/base/values/vec.h"

namespace sluice {

// The volume that kPlainNrrd describes.
inline constexpr Vec3i kNrrdDims{5, 4, 3};
// A header, all but the empty line at its end.
inline constexpr const char* kPlainNrrd =
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 5 4 3\nendian: little\nencoding: raw\n";

// kPlainNrrd with a line replaced (told by its field), added, or (empty value) left out; with its
// empty line.
inline std::string headerWith(const std::string& field, const std::string& value) {
  std::string text = kPlainNrrd;
  const size_t begin = text.find(field + ": ");
  if (begin != std::string::npos) text.erase(begin, text.find('\n', begin) + 1 - begin);
  if (!value.empty()) text += field + ": " + value + "\n";
  return text + "\n";
}

}  // namespace sluice
