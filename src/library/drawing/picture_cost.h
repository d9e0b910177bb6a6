// The cost of a picture before it is drawn: chunks, pages and bytes by algorithm, voxels to read,
// and memory. Pure functions of plans; no voxel is read.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "src/base/values/stored_reads.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/requests.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/frame_options.h"
#include "src/render/session/planner.h"
#include "src/texture/texture_plan.h"

namespace sluice {

// The visible blocks of a picture, from which each algorithm makes its own plan.
struct PlannedBlocks {
  TimeStep step;
  LookPtr look;
  VisibleBlocksPtr blocks;
  View view;
  double seconds = 0;  // classification
};

// `chooser`: see Planner::chooseBlocksBy().
PlannedBlocks plannedBlocks(const IndexedVolume& volume, const TimeStep& step,
                            const TransferFunction& transfer, const FrameOptions& frame,
                            const PageGeometry& page, BlockChooser* chooser, WorkerPool& pool);

struct AlgorithmCost {
  size_t chunks = 0, clusters = 0;
  Vec3i cluster_blocks;
  int64_t pages = 0, binds = 0;
  uint64_t bytes = 0;
  double seconds = 0;  // planning time
};
// One for each of kAlgorithms, at its place.
using AlgorithmCosts = std::array<AlgorithmCost, kAlgorithms.size()>;

AlgorithmCosts algorithmCosts(const IndexedVolume& volume, const PlannedBlocks& planned,
                              const FrameOptions& frame, const PageGeometry& page,
                              WorkerPool& pool);

struct Forecast {
  int64_t blocks = 0;        // blocks that show something
  uint64_t voxel_bytes = 0;  // decoded bytes of those blocks, as a first frame reads them
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

  uint64_t peakBytes() const { return buffer_bytes + program_bytes; }
  bool fits() const { return least_bytes <= budget_bytes && peakBytes() <= machine_bytes; }
};

// The reads of a level of the volume, from end to end and with its spreads, which level 0 has not;
// nullopt: the volume is no store of chunks. Throws Error.
std::optional<StoredReads> storedReadsOfLevel(VolumeSource& source, int64_t time, int level);

// `page`: with as many pages as the picture has. `plan_bytes`: bytes of the textures that the
// chosen algorithm makes, which count on software GL, whose textures live in memory.
// `others_bytes`: see othersBytes().
Forecast forecastOf(const IndexedVolume& volume, const VisibleBlocks& shown,
                    const PageGeometry& page, uint64_t plan_bytes, uint64_t others_bytes,
                    const FrameOptions& frame, const MachineOptions& machine);

}  // namespace sluice
