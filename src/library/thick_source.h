// A volume of one voxel along an axis as one that has a thickness there: the voxel plane twice, a
// spacing apart and centred where it was, so that it is drawn one voxel thick. Pictures are made of
// the cells between voxel planes, and a single plane has none.
#pragma once

#include <memory>

#include "src/base/volume_source.h"

namespace sluice {

// `source` itself where each axis has two voxels or more; otherwise a source over it, whose layout
// has a note that says so.
std::unique_ptr<VolumeSource> withThickness(std::unique_ptr<VolumeSource> source);

// Voxels along each axis as the volume is stored: 1 where `source` has two planes of one.
Vec3i storedDims(const VolumeSource& source);

}  // namespace sluice
