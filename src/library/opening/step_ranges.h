// The values of the steps of an open volume, as far as they are known without its voxels: from an
// index that was kept, from a pass over the voxels, or from a coarse level that stands for the
// finest one (stand_in.h).
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "src/library/opening/indexed_volume.h"

namespace sluice {

class SideLevels;

// The ranges that are known of a step's finest level.
struct StepValues {
  std::shared_ptr<const IndexedRanges> index;
  std::optional<StandIn> stand_in = {};  // if the finest level was not read
};
// The values of any step of the volume, known in the way in which its own step's are. Throws Error,
// Interrupted.
StepValues valuesOfStep(const IndexedVolume& volume, int64_t time, const IndexPass& pass);
// The min-max arrays of it.
IndexedRanges rangesOfStep(const IndexedVolume& volume, int64_t time, const IndexPass& pass);
// A step of the series, with the levels of the volume's own step and with the value range of all
// steps if the volume was opened for the whole series, so that one table of opacities serves every
// step. Throws as rangesOfStep() does.
TimeStep stepOfSeries(const IndexedVolume& volume, int64_t time, const IndexPass& pass);

// These open a volume whose source, places, layout and levels are set. All throw Error and
// Interrupted.
//
// Whether a volume is drawn at level 0 from an index that is there already, without further levels.
bool isKnown(const IndexedVolume& volume, const BlockLayout& layout);
// Passes over the voxels for the index of the volume's step and for the levels beside it.
IndexedRanges passForLevels(const IndexedVolume& volume, const IndexPass& pass,
                            const SideLevels& side);
// Makes the levels that continue those of the file, and the index of its coarsest one.
void passOverCoarsest(const IndexedVolume& volume, VolumeSource& coarsest, const SideLevels& side,
                      const IndexPass& pass);
// Adds the indices of the coarser levels that need one. Below `least` they are added if they are
// kept; otherwise it is not known what these levels show.
void indexLevels(IndexedVolume& volume, int least, const IndexPass& pass);
// The index of the volume's step, with those of coarser levels added: kept ones, a stand-in's, or
// made ones. In a hurry, no level finer than the one that may stand in is passed over.
IndexedRanges indexStep(IndexedVolume& volume, const IndexNeeds& needs, const IndexPass& pass);
// Statistics of the volume's step, or over all steps of a series, whose indices are made if they
// are missing. `index` belongs to the step that is drawn; its range is widened to the range of all
// steps.
ValueStatistics statisticsOf(const IndexedVolume& volume, IndexedRanges& index, bool whole_series,
                             const IndexPass& pass);

}  // namespace sluice
