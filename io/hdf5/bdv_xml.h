// The .xml of BigDataViewer (SpimData 0.2): where the voxels are, set-ups, time points, and the
// place of each set-up in the world.
//
// Pure but for what it is given to read from, so that it can be fuzzed.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/files/xml_scanner.h"
#include "src/base/values/vec.h"

namespace sluice {

// Rows of 3 numbers and an offset: the world from voxels.
using BdvAffine = std::array<double, 12>;

struct BdvSetup {
  int64_t id = 0;
  std::string name, unit;
  BdvAffine world{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  // at the first time point
  bool has_moved = false;                               // at another time point it differs
};

struct BdvImage {
  std::string format;  // "bdv.hdf5" or "bdv.n5"
  std::string data;    // path of the file or folder, as written
  std::vector<BdvSetup> setups;
  std::vector<int64_t> times;  // time points, ascending
  // Time points and set-ups that have no voxels.
  std::set<std::pair<int64_t, int64_t>> missing_views;
};

// Whether the first bytes are such a file's.
bool isBdvXml(std::string_view head);

// Throws Error, which starts with `path`.
BdvImage parseBdvXml(const ByteInput& input, const std::string& path);

}  // namespace sluice
