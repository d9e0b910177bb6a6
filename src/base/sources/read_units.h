// ReadUnits: the parts of a volume that its source can read alone.
//
// A few formats cannot read a single voxel or row: a chunk is decoded whole, and a compressed
// stream from its start. Code that samples a volume asks for the units, so that it reads few of
// them whole in place of a little of each.
#pragma once

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

// A plain value; the default stands for voxels that lie in a file as they are.
struct ReadUnits {
  // Reading one voxel costs as much as reading the box of this size that it lies in. Boxes tile the
  // volume from voxel (0, 0, 0) on. Each >= 1, perhaps larger than the volume.
  Vec3i voxels{1, 1, 1};
  bool is_one_stream = false;  // the first read unpacks the whole volume
};

// A VolumeSource implements this too if its units are not the default; see readUnits().
class UnitSource {
 public:
  virtual ~UnitSource() = default;
  // Constant after construction, any thread.
  virtual ReadUnits readUnits() const = 0;
};

// The source's units, or the default of single voxels.
inline ReadUnits readUnits(const VolumeSource& source) {
  const auto* units = dynamic_cast<const UnitSource*>(&source);
  return units == nullptr ? ReadUnits() : units->readUnits();
}

}  // namespace sluice
