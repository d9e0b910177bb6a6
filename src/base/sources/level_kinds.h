// LevelKinds: levels of resolution of a volume that hold something else of the finest voxels than
// the levels that every reader sees, such as maxima beside means.
#pragma once

#include <span>

#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// A VolumeSource implements this too if it may have such levels; see levelsOfKind().
class LevelKinds {
 public:
  virtual ~LevelKinds() = default;
  // The levels that hold these values, from fine to coarse, placed as those of levelsAbove() are;
  // empty: there are none. Constant after construction, any thread.
  virtual std::span<const CoarserLevel> levelsOfKind(LevelValues values) const = 0;
};

inline constexpr LevelValues kLevelKinds[] = {LevelValues::kMeans, LevelValues::kMaxima,
                                              LevelValues::kMinima, LevelValues::kModes};

// Empty: the source has no such levels. They live as long as the source.
inline std::span<const CoarserLevel> levelsOfKind(const VolumeSource& source, LevelValues values) {
  const auto* kinds = dynamic_cast<const LevelKinds*>(&source);
  return kinds == nullptr ? std::span<const CoarserLevel>() : kinds->levelsOfKind(values);
}

}  // namespace sluice
