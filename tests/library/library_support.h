// Support for the tests of the library: the program to compare with, and pictures from it.
#pragma once

#include <sluice/sluice.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "io/pictures/png_file.h"
#include "src/base/error.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace sluice {

inline constexpr const char* kShells = "synth:shells,dims=48x40x36";
inline const PictureOptions kSmall{.width = 96, .height = 80};
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// The picture of `sluice render VOLUME OPTIONS`, on whatever device it chooses. Throws Error when
// it fails.
inline Rgba8Picture programPicture(const TempFolder& folder, const std::string& arguments,
                                   const std::string& output = "program.png",
                                   const std::string& drawn = "program.png") {
  const CommandResult result =
      runCommand("cd " + shellQuoted(folder.path().string()) +
                 " && XDG_CACHE_HOME=\"$PWD/cache\" " SLUICE_PROGRAM " render " + arguments +
                 " -q --force -o " + output);
  if (result.status != 0) throw Error(result.output);
  return readPng(folder / drawn);
}

// In 1/255, of any channel; 255 if the sizes differ.
inline int largestDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  if (a.size() != b.size()) return 255;
  int largest = 0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

// The number of pixels that are not empty, so that a test does not compare nothing with nothing.
inline size_t visiblePixels(const std::vector<uint8_t>& rgba) {
  size_t visible = 0;
  for (size_t i = 3; i < rgba.size(); i += 4) visible += rgba[i] > 0 ? 1 : 0;
  return visible;
}

}  // namespace sluice
