// LevelChoice: the levels of resolution that a volume is opened with. They follow from what
// pictures need and from what the file has: its own levels, others of its file that hold values of
// another kind, or levels beside the index (side_levels.h), which may be made now. Nothing is read.
//
// The folder: side_levels.h makes and keeps levels of volumes that have none. stand_in.h and
// volume_sample.h are coarse levels for a first picture before all voxels were passed over.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "src/base/sources/volume_levels.h"
#include "src/library/requests.h"
#include "src/render/camera/cut_options.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// The levels of resolution that pictures may be drawn from: the finest alone; also those that show
// what it shows, up to the first that does not, for the default cut; or all.
enum class LevelNeeds { kFinest, kFaithful, kAll };

struct IndexNeeds {
  bool gradients = false;     // a ghost layer
  bool whole_series = false;  // values of all steps
  LevelNeeds levels = LevelNeeds::kFinest;
  // The kind of values that coarser levels must hold. If the volume's scale is negative, its levels
  // hold the other extreme of the stored numbers.
  LevelValues values = LevelValues::kMeans;
  // A volume with levels that has no index of its finest level is opened with a stand-in.
  bool may_stand_in = false;
  // If it may have a stand-in, a volume that has neither levels nor an index is opened with a
  // sample of its voxels, for which so many seconds may be spent; unset: it is passed over.
  std::optional<double> sample_seconds = {};
  // A volume that takes long to pass over is opened with all levels of its file and with a
  // stand-in, see hurriedNeeds().
  bool opens_soon = false;
};
// `cut`: the cut that pictures are drawn from; unset: the finest level.
IndexNeeds needsOf(const LookArguments& look, Mode mode,
                   const std::optional<CutOptions>& cut = std::nullopt);
// The needs of a picture without options, so that an index made ahead serves it.
inline constexpr IndexNeeds kUsualNeeds{.gradients = true, .levels = LevelNeeds::kFaithful};

// The needs in terms of the numbers that a volume stores, which may fall as its values rise.
IndexNeeds storedNeeds(IndexNeeds needs, const ValueMap& map);
// The needs of a volume that is opened soon: if its file has levels that pictures may be drawn
// from, and if the volume is large (isLarge()) or far away, all levels and a stand-in.
IndexNeeds hurriedNeeds(IndexNeeds needs, const VolumeSource& source);

// The needs without levels if blocks of this size have no room for their border and nobody has
// asked for levels: whether levels are kept from an earlier command must not decide whether a
// picture is drawn. `wish`: the user's.
IndexNeeds needsOfBlocks(int64_t block, IndexNeeds needs, LevelsWish wish);

struct LevelChoice {
  // Pictures may be drawn from the levels of the file: there are none, or they hold the values that
  // pictures need. If a writer does not say how it made its levels, they are taken for means.
  bool own_suit = true;
  // Levels beside the index: of which kind they are follows from the needs.
  LevelsWish beside = LevelsWish::kNone;
  // A sample of the coarsest level may stand for the volume if nothing else is there.
  bool may_sample = false;
};
// `wish`: the user's. `needs`: in terms of the stored numbers.
LevelChoice chooseLevels(VolumeSource& source, const IndexNeeds& needs, LevelsWish wish);

// The volume with those levels of its file that pictures need, if they are beside others.
std::unique_ptr<VolumeSource> withLevelsFor(std::unique_ptr<VolumeSource> source,
                                            const IndexNeeds& needs);
// The volume as one of a single level.
std::unique_ptr<VolumeSource> withoutLevels(std::unique_ptr<VolumeSource> source);
// The levels above the finest that pictures may be drawn from.
std::span<const CoarserLevel> levelsFor(const VolumeSource& source, const IndexNeeds& needs);

}  // namespace sluice
