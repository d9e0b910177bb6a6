// FrameRun: one frame from its values to its picture. It makes missing data resident, cluster by
// cluster, and passes each cluster's boxes to the device. It is destroyed after the frame together
// with everything that belonged to this frame alone. What the next frame may use from it is passed
// on as a value.
//
// It may end at any point: by its stop token, by a source that fails. Then its destructor leaves
// all levels consistent, and the next frame draws as if this one had not been. Used on one thread,
// the device's.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cache/trace/trace.h"
#include "src/render/blocks/visible_blocks.h"
#include "src/render/camera/frame_options.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/frame/level_fades.h"
#include "src/render/session/boxes_ahead.h"
#include "src/render/session/read_ahead.h"
#include "src/render/session/residency.h"

namespace sluice {

// The chain's values for one frame, and the options that they do not contain.
struct FrameValues {
  TimeStep step;
  LookPtr look;
  VisibleBlocksPtr visible;
  FramePlanPtr plan;
  DrawOrderPtr order;
  ChosenBoxesPtr boxes;  // null: object boxes are drawn
  FrameSetup setup;
  FrameOptions options;
  std::chrono::steady_clock::time_point asked_at;
  // Called once all is read that the frame needs, before the rest of it is drawn; may be empty.
  std::function<void()> when_read = {};
};

// Values that the next frame uses from this one.
struct FrameLessons {
  // The first number of map updates. The paper's machine took 9. Here each update waits for the
  // slowest of the threads: 2 to 3 gave the shortest frames on software GL. On the CPU device, 6 or
  // 9 gain in one volume what they lose in another.
  static constexpr UpdateCountOptions kUpdates{.first = 3};

  BlockClasses blocks;
  double draw_s = 0;  // drawing time
  // The updates are those of frames with this occlusion.
  Occlusion occlusion = Occlusion::kOff;
  UpdateCount updates{kUpdates};
  // The chunks of which the last frame of this plan with this occlusion drew something. Chunks that
  // it hid are not read ahead. Empty: not known.
  std::weak_ptr<const FramePlan> plan;
  IndexedVector<ChunkPosition, bool> shown;
  // Reading of the data that a frame left out at its time limit goes on until the next frame
  // begins.
  std::unique_ptr<ReadAhead> unfinished;
};

class FrameRun {
 public:
  // All references must outlive the run. `trace` may be null; it records the requests as those of
  // frame `number`.
  FrameRun(FrameValues values, Residency& residency, Device& device, TraceWriter* trace,
           int64_t number, const FrameLessons& lessons);
  ~FrameRun();
  FrameRun(const FrameRun&) = delete;
  FrameRun& operator=(const FrameRun&) = delete;

  // To be called once. Throws Error, and Interrupted when it is stopped.
  Picture draw();

  // Requires draw() before. Counting samples and drawing single phases each take passes of their
  // own.
  void countSamples();
  std::vector<FramePhase> drawPhases();
  FrameReport& report() { return report_; }
  // To be called once, last.
  FrameLessons lessons();

 private:
  using Deadline = ReadAhead::Deadline;
  struct Phase {
    std::optional<OpacityMap> map;
    std::vector<BoxDraw> drawn;
  };

  // Reports so many visits as drawn; whoever watches may have asked to stop.
  void tellProgress(size_t visits) const;
  Deadline deadline() const;
  ReadAhead::Needs needs() const;
  void startOcclusion();
  void makeResident(const ReadAhead::Taken& taken);
  void drawBlocks(const std::vector<BlockPosition>& order);
  void drawBlock(BlockPosition position);
  bool hasBorders(const TextureBlock& block) const;
  // The block's cells with its borders, see level_borders.h.
  Box3 reachOf(const TextureBlock& block) const;
  // Draws the block's object box where it meets other levels, with the boxes around it.
  void drawWithBorders(BlockPosition position, BoxDraw box);
  struct SeamBox {
    ChunkPosition chunk;
    BoxDraw box;
  };
  // Draws the box, or its part that is not hidden, with the boxes that join it there.
  void drawBox(ChunkPosition chunk, BoxDraw box, std::span<const SeamBox> joined = {});
  void flushBoxes();
  void updateOpacityMap();
  void gatherCounters();
  bool isHidden(BlockPosition block) const;
  const TexturePlan& textures() const { return values_.plan->textures; }

  const FrameValues values_;
  const FrameOptions& options_;
  Residency& residency_;
  Device& device_;
  TraceWriter* const trace_;
  const int64_t number_;
  const FrameLessons& last_;
  const std::shared_ptr<ReadTally> tally_ = std::make_shared<ReadTally>();

  FrameReport report_;
  UpdateCount updates_;
  LevelFades fades_;  // of surfaces
  std::optional<FrameOcclusion> occlusion_;
  IndexedVector<ChunkPosition, bool> shown_;  // with occlusion: chunks with visible boxes
  std::unique_ptr<ReadAhead> ahead_;
  std::optional<BoxesAhead> boxes_;
  std::vector<BoxDraw> pending_;  // drawn next
  std::vector<BoxDraw> counted_;  // all of the frame's boxes, if its samples are to be counted
  std::vector<Phase> phases_;     // if they are kept
  double missing_cells_ = 0;
  bool is_drawn_ = false;
};

}  // namespace sluice
