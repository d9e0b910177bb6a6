// The public volumes that tests draw if they are present (SLUICE_DATA_DIR), by the name that a user
// would give; skipped by name if not. datasets.md describes each.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>

#include "src/base/sources/volume_source.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

struct RealVolume {
  const char* name;        // name of the test
  const char* input;       // within the folder: a file, a folder or a pattern
  Vec3d spacing{0, 0, 0};  // the user's --spacing; 0: none
  int64_t time = 0;
  friend void PrintTo(const RealVolume& volume, std::ostream* out);
};

std::span<const RealVolume> realVolumes();
// The folder of all.
std::filesystem::path realVolumesFolder();
// Null if the volume is not there. Throws Error if it cannot be read.
std::unique_ptr<VolumeSource> openReal(const RealVolume& volume);

// The automatic choice of `sluice render FILE`.
TransferFunction automaticFor(const SliceRanges& ranges, const VolumeLayout& layout);

}  // namespace sluice
