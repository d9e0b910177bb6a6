// FrameRun: one frame from its values to its picture. It makes resident what is missing, cluster by
// cluster, hands each cluster's boxes to the device, and is gone with everything that belonged to
// this frame alone. What the next frame may learn from it is handed over as a value.
//
// It may end at any point: by its stop token, by a source that fails. Then its destructor leaves
// all levels right, and the next frame draws as if this one had not been. One thread, the device's.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "cache/trace/trace.h"
#include "src/render/boxes_ahead.h"
#include "src/render/frame_options.h"
#include "src/render/frame_setup.h"
#include "src/render/read_ahead.h"
#include "src/render/residency.h"
#include "src/render/visible_blocks.h"

namespace sluice {

// The chain's values for one frame, and the options that they do not say.
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

// What a frame tells the next.
struct FrameLessons {
  // Where the numbers of map updates begin. The paper's machine took 9; here each update waits for
  // the slowest of the threads: 2 to 3 gave the shortest frames on software GL, and on the CPU
  // device what 6 or 9 hide more in one volume they cost in the next.
  static constexpr UpdateCountOptions kUpdates{.first = 3};

  BlockClasses blocks;
  double draw_s = 0;  // that drawing took
  // Of frames with this occlusion.
  Occlusion occlusion = Occlusion::kOff;
  UpdateCount updates{kUpdates};
  // Of the last frame of this plan with this occlusion: chunks of which something was drawn. What
  // it hid is not read ahead. Empty: not known.
  std::weak_ptr<const FramePlan> plan;
  IndexedVector<ChunkPosition, bool> shown;
  // What a frame left out at its time limit: reading goes on until the next one begins.
  std::unique_ptr<ReadAhead> unfinished;
};

class FrameRun {
 public:
  // All references must outlive the run. `trace` may be null; requests are written there as those
  // of frame `number`.
  FrameRun(FrameValues values, Residency& residency, Device& device, TraceWriter* trace,
           int64_t number, const FrameLessons& lessons);
  ~FrameRun();
  FrameRun(const FrameRun&) = delete;
  FrameRun& operator=(const FrameRun&) = delete;

  // Once. Throws Error, and Interrupted when it is stopped.
  Picture draw();

  // After draw(). What the device counts and what each phase drew takes passes of its own.
  void countSamples();
  std::vector<FramePhase> drawPhases();
  FrameReport& report() { return report_; }
  // Once, last.
  FrameLessons lessons();

 private:
  using Deadline = ReadAhead::Deadline;
  struct Phase {
    std::optional<OpacityMap> map;
    std::vector<BoxDraw> drawn;
  };

  // After so many visits; whoever watches may have asked to stop.
  void tellProgress(size_t visits) const;
  Deadline deadline() const;
  ReadAhead::Needs needs() const;
  void startOcclusion();
  void makeResident(const ReadAhead::Taken& taken);
  void drawBlocks(const std::vector<BlockPosition>& order);
  void drawBlock(BlockPosition position);
  // Draws the box, or what is not hidden of it, with those around it.
  void drawBox(ChunkPosition chunk, BoxDraw box);
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
  std::optional<FrameOcclusion> occlusion_;
  IndexedVector<ChunkPosition, bool> shown_;  // with occlusion: chunks of which something was drawn
  std::unique_ptr<ReadAhead> ahead_;
  std::optional<BoxesAhead> boxes_;
  std::vector<BoxDraw> pending_;  // drawn next
  std::vector<BoxDraw> counted_;  // all of the frame's, where its samples are to be counted
  std::vector<Phase> phases_;     // where they are kept
  double missing_cells_ = 0;
  bool is_drawn_ = false;
};

}  // namespace sluice
