// The report of a frame: its work and its costs. Plain data, gathered by the frame itself
// (frame_run.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/values/picture.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/frame/frame_occlusion.h"
#include "src/render/frame/pixel_rays.h"

namespace sluice {

// Seconds of wall clock, but read, decode and copy: summed over all threads that did it.
struct StageSeconds {
  double classify = 0, plan = 0, read = 0, decode = 0, copy = 0, upload = 0, draw = 0;
  double light = 0;  // what arrives of it was computed
  double boxes = 0;  // drawing waited for growing boxes: made or read, and those to draw chosen
};

// See the fields of the same names in FrameReport.
struct MovedBytes {
  uint64_t decoded = 0, copied = 0, uploaded = 0;

  MovedBytes& operator+=(const MovedBytes& more);
};

struct BlockClasses {
  int64_t white = 0, grey = 0, black = 0;

  BlockClasses& operator+=(const BlockClasses& more);
};

struct FrameReport {
  double seconds = 0;
  double step_vox = 1;  // between slices
  PixelRays rays;
  StageSeconds stages;
  // When counted: samples in the boxes that were drawn, and the samples that the device took of
  // them, fewer if rays end early and pixels are stopped (with depth: not counted, all).
  uint64_t samples_drawn = 0, samples_taken = 0;
  Vec3i light_texels{0, 0, 0};  // of the light volume; 0: all light arrives everywhere
  uint64_t samples_object = 0;  // samples inside object boxes, whether drawn or not
  int64_t boxes_drawn = 0;      // handed to the device
  BlockClasses blocks;
  BlockClasses before;                          // classes of the last frame; all 0 for the first
  int64_t clusters = 0, chunks = 0, pages = 0;  // counts of the plan
  // The work of this frame.
  uint64_t pages_loaded = 0, binds = 0;
  uint64_t decoded_bytes = 0;   // voxels that level 2 read, those for growing boxes too
  uint64_t copied_bytes = 0;    // voxels into the texture buffer
  uint64_t uploaded_bytes = 0;  // whole pages copied into the texture cache
  MovedBytes rebuild;           // bytes that a frame moves if it starts from nothing
  // The share of the visible cells that was left out at the time limit. 0: the picture is complete.
  double missing_share = 0;
  OcclusionReport occlusion;      // for a frame with occlusion
  std::optional<CutSummary> cut;  // for a frame of several levels of resolution
};

// Adds the work and the time of a further strip of a picture to those of its first strips. Blocks
// and plans count the whole picture already.
void addStrip(FrameReport& sum, const FrameReport& strip);

// Adds the report of another volume that shows in the same picture.
void addLayer(FrameReport& sum, const FrameReport& layer);

// The boxes drawn between two updates of the opacity map (Li 2003, Figure 8).
struct FramePhase {
  Picture picture;  // picture of these boxes alone, as far as their chunks are still resident
  std::optional<OpacityMap> map;  // the map that culled them; none before the first update
};

struct Frame {
  Picture picture;
  FrameReport report;
  std::vector<FramePhase> phases;  // if they are kept
  VisibleBlocksPtr blocks;         // blocks that it drew
};

}  // namespace sluice
