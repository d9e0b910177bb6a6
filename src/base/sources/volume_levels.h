// The levels of resolution of a volume, and the places of their voxels.
//
// Index space is continuous: the centre of voxel (i, j, k) is at (i, j, k). A level whose voxels
// are the means of 2 x 2 x 2 finer ones has a scale of 2 and an offset of 1/2, because the mean of
// voxels 0 and 1 lies half way between their centres. A level that keeps every second voxel has a
// scale of 2 and an offset of 0. Scales may differ from axis to axis and need not be whole numbers.
#pragma once

#include <span>

#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"

namespace sluice {

// A plain value; the default is the finest level itself.
struct LevelPlacement {
  Vec3d scale{1, 1, 1};  // finest voxels from one voxel of the level to the next, each > 0
  Vec3d offset{0, 0,
               0};  // position of the level's voxel (0, 0, 0) in the finest level's index space
  friend constexpr bool operator==(const LevelPlacement&, const LevelPlacement&) = default;

  Vec3d finestFromLevel(Vec3d index) const { return offset + scale * index; }
  Vec3d levelFromFinest(Vec3d index) const { return (index - offset) / scale; }
};

// The type that spreads and shares of voxels of `type` are kept in: as wide as the numbers that are
// drawn, and never negative.
constexpr VoxelType spreadType(VoxelType type) {
  switch (type) {
    case VoxelType::kU8:
    case VoxelType::kI8:
      return VoxelType::kU8;
    case VoxelType::kU16:
    case VoxelType::kI16:
      return VoxelType::kU16;
    default:
      return VoxelType::kF32;
  }
}

// Bytes as they are stored of a voxel that has 1 number, or 2 with its spread.
inline size_t storedBytesPerVoxel(VoxelType type, int numbers) {
  return bytesPerVoxel(type) + (numbers == 2 ? bytesPerVoxel(spreadType(type)) : 0);
}

// How the voxels of a coarser level follow from the finest ones that they stand for. Of the last
// three each voxel has a value that occurs among these.
enum class LevelValues { kUnknown, kMeans, kMaxima, kMinima, kModes };

struct CoarserLevel {
  VolumeSource* source = nullptr;  // owned by the source it is a level of
  LevelPlacement placement;        // among the voxels of that source
  // A second number for each voxel, of type spreadType(). If the voxels are means: the spread of
  // the finest voxels that each stands for, which is twice their standard deviation in units of
  // stored values. If they are modes: the share of those finest voxels that have another value, 0
  // for none and the greatest number of the type (1 of floats) for all. The dims and time steps are
  // the level's. Null: it is not known.
  VolumeSource* spreads = nullptr;
  bool is_computed = false;  // from voxels of the finest level whenever it is read
  LevelValues values = LevelValues::kUnknown;
};

// Whether a level of these values shows something where the finest level does, and nowhere else: it
// needs no ranges of its own then.
constexpr bool showsAsFinest(LevelValues values, bool has_spreads) {
  return has_spreads || values == LevelValues::kMaxima || values == LevelValues::kMinima ||
         values == LevelValues::kModes;
}

// A VolumeSource implements this too if it has coarser levels; see coarserLevels().
class LeveledSource {
 public:
  virtual ~LeveledSource() = default;
  // The levels from fine to coarse, without level 0, which is the source itself. The levels have
  // its type, time steps, value scale and value offset; their place in the world follows from its
  // layout and the placement alone, whatever their own layouts say. Constant after construction,
  // any thread.
  virtual std::span<const CoarserLevel> levelsAbove() const = 0;
};

// The coarser levels of a source; empty if it has one level.
inline std::span<const CoarserLevel> coarserLevels(const VolumeSource& source) {
  const auto* leveled = dynamic_cast<const LeveledSource*>(&source);
  return leveled == nullptr ? std::span<const CoarserLevel>() : leveled->levelsAbove();
}

}  // namespace sluice
