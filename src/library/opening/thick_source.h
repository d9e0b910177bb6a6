// Gives a volume of one voxel along an axis a thickness there: the voxel plane twice, a spacing
// apart and centred where it was, so that it is drawn one voxel thick. Pictures are made of the
// cells between voxel planes, and a single plane has none.
#pragma once

#include <memory>

#include "src/base/sources/volume_source.h"

namespace sluice {

// `source` itself if each axis has two voxels or more; otherwise a source over it, whose layout has
// a note about it.
std::unique_ptr<VolumeSource> withThickness(std::unique_ptr<VolumeSource> source);

// The layout as the file has it: one voxel along an axis that `source` draws as two planes, and the
// file's origin. Valid as long as `source`.
const VolumeLayout& storedLayout(const VolumeSource& source);

}  // namespace sluice
