// The cost of a picture before it is drawn: chunks, pages and bytes by algorithm, voxels to read,
// and memory. Pure functions of plans; no voxel is read. At most one plan is in memory at a time:
// planBytes() counts it.
//
// The folder: picture_cost.h is the cost of one session's picture, planned_channels.h adds up those
// of a picture's channels, picture_memory.h divides large pictures into strips, wanted_reads.h
// counts what the strips read again, and picture_plan.h is the public plan.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/base/sources/stored_reads.h"
#include "src/device/device.h"
#include "src/library/drawing/cost/wanted_reads.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/requests.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/frame_options.h"
#include "src/render/session/planner.h"
#include "src/texture/plan_totals.h"
#include "src/texture/texture_plan.h"

namespace sluice {

// The visible blocks of a picture, from which each algorithm makes its own plan.
struct PlannedBlocks {
  TimeStep step;
  LookPtr look;
  VisibleBlocksPtr blocks;
  View view;
  double seconds = 0;                    // classification
  TexturePlanPtr clusters = {};          // PlanOptions::clusters, of channels that are blended
  std::vector<PictureRows> strips = {};  // of the picture, from plannedStrips()
};

// The strips in which the picture is drawn; one: it is drawn whole. `others_bytes`: see
// othersBytes().
std::vector<PictureRows> plannedStrips(const IndexedVolume& volume, const MachineOptions& machine,
                                       const FrameOptions& frame, uint64_t others_bytes);

// A volume's part of a picture.
struct PlannedPart {
  const IndexedVolume& volume;
  TimeStep step;
  const TransferFunction& transfer;
  FrameOptions frame;
  PageGeometry page;
};
// `chooser`: see Planner::chooseBlocksBy().
PlannedBlocks plannedBlocks(const PlannedPart& part, BlockChooser* chooser, WorkerPool& pool);
// The same of channels that are blended, see Session::parts().
std::vector<PlannedBlocks> plannedTogether(std::span<const PlannedPart> parts, WorkerPool& pool);

struct AlgorithmCost : PlanTotals {
  // The reads of a first frame if no block stays in memory between two strips of the picture, or
  // two clusters, that need it.
  WantedReads wanted = {};
  double seconds = 0;  // planning time
};
// One for each of kAlgorithms, at its place.
using AlgorithmCosts = std::array<AlgorithmCost, kAlgorithms.size()>;

// Throws Error when the texture cache has fewer pages than one block.
AlgorithmCosts algorithmCosts(const IndexedVolume& volume, const PlannedBlocks& planned,
                              const FrameOptions& frame, const PageGeometry& page,
                              WorkerPool& pool);

struct Forecast {
  // The blocks that the algorithm loads, and their decoded bytes: the reads of a first frame if all
  // of them stay in memory.
  int64_t blocks = 0;
  uint64_t voxel_bytes = 0;
  // The most blocks that a first frame reads, and their decoded bytes: more than the above if the
  // memory does not hold all blocks, since a block is then read again for each strip of the picture
  // that shows its chunk and each cluster that needs it. Growing boxes that are not kept yet read
  // blocks once more.
  int64_t most_blocks = 0;
  uint64_t most_voxel_bytes = 0;
  // The reads of a first frame from a store of chunks; unset: the volume is none.
  std::optional<StoredReads> stored = {};
  // The memory that MachineOptions::memory_bytes bounds: its value, the least that works, and the
  // frame's need.
  uint64_t budget_bytes = 0, least_bytes = 0, buffer_bytes = 0;
  uint64_t index_bytes = 0;  // the part of buffer_bytes for the min-max arrays
  // The part of buffer_bytes for the picture, or for a strip of it, until it is written.
  uint64_t picture_bytes = 0;
  uint64_t program_bytes = 0;  // in addition to it: the program and its driver
  uint64_t machine_bytes = 0;  // limit for this process
  // Whether the budget is at least least_bytes. Each of several channels has its own share of the
  // budget, so that all of them together can have enough and one too little.
  bool fits_budget = false;

  uint64_t peakBytes() const { return buffer_bytes + program_bytes; }
  bool fits() const { return fits_budget && peakBytes() <= machine_bytes; }
};

// The reads of a level of the volume, from end to end and with its spreads, which level 0 has not;
// nullopt: the volume is no store of chunks. Throws Error.
std::optional<StoredReads> storedReadsOfLevel(VolumeSource& source, int64_t time, int level);

// Throws Error, as the session of such a picture does, when the memory has no room for its plan and
// the rest of `others_bytes` (see othersBytes()). `page`: with as many pages as the picture has.
void requireRoomToPlan(const IndexedVolume& volume, const PageGeometry& page, uint64_t others_bytes,
                       const FrameOptions& frame, const MachineOptions& machine, TexelPlace texels);

struct ForecastInputs {
  const IndexedVolume& volume;
  const PlannedBlocks& planned;
  const PageGeometry& page;   // with as many pages as the picture has
  const AlgorithmCost& cost;  // of the algorithm that draws
  uint64_t others_bytes = 0;  // see othersBytes()
  const FrameOptions& frame;
  const MachineOptions& machine;
  TexelPlace texels = TexelPlace::kInMemory;  // of the device that draws
};
Forecast forecastOf(const ForecastInputs& inputs);

}  // namespace sluice
