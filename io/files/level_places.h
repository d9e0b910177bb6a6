// The coarser levels of an image as its file describes them: checked against their shapes, and the
// places of their voxels among those of the finest one.
//
// Many writers give a scale alone. Then either the corners of the first voxels coincide (levels of
// means, whose centres move by half a finer voxel) or their centres do (levels of every n-th
// voxel); comparing the voxels of two levels tells which. Pure functions but for originOf(), which
// reads.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

// A level's placement according to the metadata, along x, y and z.
struct LevelClaim {
  Vec3i dims;                        // voxels of its array
  std::optional<Vec3d> scale;        // world units a voxel; negative: the axis is turned
  std::optional<Vec3d> translation;  // translation of the first voxel's centre
};

// Finest voxels per voxel of a level: the ratio of the scales if both are given; otherwise, of the
// shapes, the whole number that leaves as many voxels, rounded either way, or else their ratio.
Vec3d levelFactor(const LevelClaim& finest, const LevelClaim& level);

// Why a level cannot be used, for a message; empty if it can. Reasons: it is finer than the first
// one, as large, or its scale contradicts its shape by a voxel or more.
std::string faultOfLevel(const LevelClaim& finest, const LevelClaim& level);

enum class VoxelOrigin { kCorner, kCentre };

// The position of the level's first voxel if it has no translation, in finest voxels.
Vec3d offsetOf(VoxelOrigin origin, Vec3d factor);

// The origin that the voxels of a coarse level show, compared with a finer one `factor` times as
// fine; nullopt: both fit, or neither does. Reads some ten thousand voxels of each at time step 0,
// where the coarse ones differ most. Throws Error from the sources.
std::optional<VoxelOrigin> originOf(VolumeSource& fine, VolumeSource& coarse, Vec3d factor);

// Sets the offsets of levels without a translation, the finest first, by the origin of two of them:
// the coarsest that have a few voxels a side. Returns a note about it. Requires: not empty, with
// scales.
std::string findOrigin(VolumeSource& finest, std::span<CoarserLevel> levels);

}  // namespace sluice
