// The public volumes that tests draw where they are present (SLUICE_DATA_DIR), by what a user would
// name; skipped by name where not. datasets.md says what each is.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>

#include "src/base/volume_source.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/volume/slice_ranges.h"

namespace sluice {

struct RealVolume {
  const char* name;        // of the test
  const char* input;       // within the folder: a file, a folder or a pattern
  Vec3d spacing{0, 0, 0};  // what a user says beside the name; 0: nothing
  int64_t time = 0;
  friend void PrintTo(const RealVolume& volume, std::ostream* out);
};

std::span<const RealVolume> realVolumes();
// The folder of all.
std::filesystem::path realVolumesFolder();
// Null where the volume is not there. Throws Error where it cannot be read.
std::unique_ptr<VolumeSource> openReal(const RealVolume& volume);

// What `sluice render FILE` alone would choose.
TransferFunction automaticFor(const SliceRanges& ranges, const VolumeLayout& layout);

}  // namespace sluice
