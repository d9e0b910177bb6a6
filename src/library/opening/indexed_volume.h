// IndexedVolume: a volume with everything known about it without its voxels (the min-max arrays and
// value counts); no device. Pictures, plans and simulations start from it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cache/model/page_geometry.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"
#include "src/index/indexed_ranges.h"
#include "src/library/drawing/chosen_look.h"
#include "src/library/opening/shown_channels.h"
#include "src/library/opening/stand_in.h"
#include "src/library/requests.h"
#include "src/render/blocks/time_step.h"
#include "src/render/camera/cut_options.h"

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
  // With levels: a volume that has no index of its finest level is opened with a stand-in.
  bool may_stand_in = false;
  // With may_stand_in: a volume that has neither levels nor an index is opened with a sample of its
  // voxels, for which so many seconds may be spent; unset: it is passed over.
  std::optional<double> sample_seconds = {};
};
// `cut`: the cut that pictures are drawn from; unset: the finest level.
IndexNeeds needsOf(const LookArguments& look, Mode mode,
                   const std::optional<CutOptions>& cut = std::nullopt);
// The needs of a picture without options, so that an index made ahead serves it.
inline constexpr IndexNeeds kUsualNeeds{.gradients = true, .levels = LevelNeeds::kFaithful};

struct IndexedVolume {
  std::unique_ptr<VolumeSource> source;
  std::string name;      // name given by the user; the first of several
  ShownChannel channel;  // the one that the source reads
  IndexPlaces places;    // places of its indices
  ValueMap map;
  PageGeometry page;
  BlockLayout layout;
  int64_t time = 0;
  std::shared_ptr<const IndexedRanges>
      index;                        // of this step; without values if there is a stand-in
  std::optional<StandIn> stand_in;  // in place of the finest level, which was not read then
  // The sample that is the one level above the finest, if that was all there was time for.
  struct Sample {
    std::string part;         // the part of the file that it was read from, for people
    uint64_t held_bytes = 0;  // its voxels
  };
  std::optional<Sample> sample;
  ValueStatistics values;  // of its step, or of the series
  IndexNeeds needs;        // those that it was opened for
  // Levels above the finest, of the same step, from fine to coarse: null and empty where there are
  // none or none was asked for. A level that shows as the finest one does has no index: null.
  std::shared_ptr<const PyramidLayout> pyramid;
  std::vector<std::shared_ptr<const IndexedRanges>> coarser;
  // For people, one line each: choices among several, and possible faults.
  std::vector<std::string> notes;

  TimeStep step() const;
  // The most that a voxel of a level has: 2 if a level has spreads.
  int numbers() const;
  // Of the min-max arrays and brick ranges of all levels, and of a sample.
  uint64_t rangesBytes() const;
  // A line for people about the stand-in; empty if there is none.
  std::string standInNote() const;
  // Least and greatest value that can be told from infinities.
  ValueRange valueRange() const { return values.range; }
  // Least and greatest finite value, of the step.
  ValueRange finiteRange() const;
};

// The pass over the voxels if an index is missing: its threads, limits and watcher.
struct IndexPass {
  WorkerPool& pool;
  ProgressMeter& progress;
  uint64_t memory_bytes = UINT64_MAX;
  StopToken stop = {};
  // Told beforehand what will be written in addition to the index, and how large it is; may be
  // null.
  std::function<void(const std::string& line)> announce = {};
};

// Opens the volume and checks that it has the time step. A volume of one voxel along an axis is
// made thick enough to be drawn (thick_source.h). Throws Error.
std::unique_ptr<VolumeSource> openSource(const VolumeArguments& arguments);
// The same of a source that is open already.
std::unique_ptr<VolumeSource> checkedSource(std::unique_ptr<VolumeSource> opened,
                                            const VolumeArguments& arguments);
// Reads or builds the index of the step, or of all steps. `source` belongs to `arguments`. Throws
// Error, Interrupted.
IndexedVolume indexVolume(std::unique_ptr<VolumeSource> source, const VolumeArguments& arguments,
                          const MachineOptions& machine, const IndexNeeds& needs,
                          const IndexWish& wish, const IndexPass& pass);

// The min-max arrays of any step of the volume, like its own step's in IndexedVolume. Throws Error,
// Interrupted.
IndexedRanges rangesOfStep(const IndexedVolume& volume, int64_t time, const IndexPass& pass);
// A step of the series, with the levels of the volume's own step and with the value range of all
// steps if the volume was opened for the whole series, so that one table of opacities serves every
// step. Throws as rangesOfStep() does.
TimeStep stepOfSeries(const IndexedVolume& volume, int64_t time, const IndexPass& pass);

// The look of the volume's channel.
ChosenLook lookFor(const IndexedVolume& volume, const LookArguments& look, Mode mode);

}  // namespace sluice
