// IndexedVolume: a volume with everything known about it without its voxels (the min-max arrays and
// value counts); no device. Pictures, plans and simulations start from it.
//
// The folder: here, opening a source (checked_source.h) and finding out what is known of its steps
// and channels (step_ranges.h, shown_channels.h). levels/ has the levels of resolution that it is
// opened with, and coarse values that stand for fine ones until these are known.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cache/model/page_geometry.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"
#include "src/index/indexed_ranges.h"
#include "src/library/drawing/scene/chosen_look.h"
#include "src/library/opening/levels/level_choice.h"
#include "src/library/opening/levels/stand_in.h"
#include "src/library/opening/shown_channels.h"
#include "src/library/requests.h"
#include "src/render/blocks/time_step.h"

namespace sluice {

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
  bool was_hurried = false;         // hurriedNeeds() made a difference
  // The level whose values may stand for the finest one of any step; 0: none may.
  int stand_in_level = 0;
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
  std::string levels_fault;  // why further levels of the source are left out; empty: none are
  // For people, one line each: choices among several, and possible faults.
  std::vector<std::string> notes;

  // The step that was opened, with its levels. Refers to this volume, which must outlive it.
  TimeStep step() const;
  // The most that a voxel of a level has: 2 if a level has spreads.
  int numbers() const;
  // Of the min-max arrays and brick ranges of all levels, and of a sample.
  uint64_t rangesBytes() const;
  // A line for people about the coarse level that stands in; empty if none does.
  std::string standInNote() const;
  // Least and greatest value that can be told from infinities.
  ValueRange valueRange() const { return values.range; }
  // Least and greatest finite value, of the step.
  ValueRange finiteRange() const;
};

// The pictures to be drawn, as far as they are known before the volume: a budget for them follows.
struct ExpectedPictures {
  uint64_t picture_bytes = 0;    // of one, at least; 0: nothing is known of its size
  uint64_t light_bytes = 0;      // of light that looks around
  bool grows_boxes = false;      // Partition::kBoxes
  bool is_compared = false;      // with one in other blocks (comparingBytes())
  bool judges_surfaces = false;  // of several levels
  int64_t pages = 0;             // of the texture cache, as the user says; 0: the least
};

// The pass over the voxels if an index is missing.
struct IndexPass : VolumePass {
  // Told beforehand what will be written in addition to the index, and how large it is; may be
  // null.
  std::function<void(const std::string& line)> announce = {};
  LayersTogether together = {};  // the layers that the volume is drawn with
  ExpectedPictures pictures = {};
};

// Reads or builds the index of the step, or of all steps. `source` belongs to `arguments`. Throws
// Error, Interrupted.
IndexedVolume indexVolume(std::unique_ptr<VolumeSource> source, const VolumeArguments& arguments,
                          const MachineOptions& machine, const IndexNeeds& needs,
                          const IndexWish& wish, const IndexPass& pass);

// The standInNote() of each volume that has one, each line once. If only some of a file's channels
// have one, the lines name these.
std::vector<std::string> standInNotes(std::span<const IndexedVolume* const> volumes);

// The look of the volume's channel.
ChosenLook lookFor(const IndexedVolume& volume, const LookArguments& look, Mode mode);

}  // namespace sluice
