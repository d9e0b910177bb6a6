// VolumeSample: an evenly spread part of a volume's voxels as a coarse level, for a first picture
// that does not wait for a pass over all of them.
//
// Voxels lie on a grid with equal steps along each axis. From files that can be read row by row,
// slices are read at a step along z, and of each the voxels of the grid; more slices, between
// those, follow as long as the time allows. From files of chunks, whole chunks are read at a step
// along each axis, and grid points in other chunks get the value of the nearest one that was read.
// The voxels are those of the volume, not means: their counts estimate the volume's, and thin
// structures between them are missing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

// A sample takes at most one part in so many of the memory.
inline constexpr uint64_t kSampleMemoryShare = 8;

struct SampleRequest {
  VolumeSource& source;
  int64_t time = 0;
  WorkerPool& pool;
  // The sample takes at most one part in kSampleMemoryShare of this, and reading it as much again.
  uint64_t memory_bytes = UINT64_MAX;
  // No further slices are read if that seems to take longer. The first ones are read whatever the
  // time.
  double seconds = 0;
  StopToken stop = {};
};

struct VolumeSample {
  Vec3i dims;
  LevelPlacement placement;       // scales and offsets are whole numbers
  std::vector<std::byte> voxels;  // of the source's type, x fastest
  // The part of the file that was read, for people: "128 of 2048 slices".
  std::string part;
};

// Requires: canSample(). Throws Error if the source cannot be read, Interrupted.
VolumeSample sampleVolume(const SampleRequest& request);

// Whether a first pass over the volume seems to take longer than this, and the volume is thick
// enough for a coarser level.
bool isWorthSampling(const VolumeLayout& layout, double seconds);

// `source` with a sample of its coarsest level, or of itself if it has one level, as a further
// level, which has no spreads. Reading the level reads memory.
std::unique_ptr<VolumeSource> withSample(std::unique_ptr<VolumeSource> source, VolumeSample sample);

}  // namespace sluice
