// BallPyramid: an OME-Zarr image as another program might leave it: several levels of means without
// spreads, uncompressed chunks, none where the volume is empty, no index. It shows a ball, brighter
// towards its middle, in a volume that may be as large as one likes: only chunks that the ball
// touches are files.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/values/vec.h"

namespace sluice {

struct BallPyramid {
  Vec3i dims{1024, 512, 512};
  int levels = 4;      // each halves all axes
  int time_steps = 1;  // above 1, the ball moves along x by a radius a step
  int64_t chunk = 64;
  Vec3d middle{400, 250, 260};  // of the finest voxels
  double radius = 100;

  // The value of a point among the finest voxels, as all levels have it: 0 outside of the ball, 80
  // at its face and 240 in the middle.
  double valueAt(Vec3d finest, int64_t time = 0) const;
  // Writes the store. Throws Error.
  void write(const std::filesystem::path& folder) const;
};

// Makes each chunk of a level unreadable, so that reading one is an error.
void spoilLevel(const std::filesystem::path& pyramid, int level);

}  // namespace sluice
