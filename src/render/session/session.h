// Session: a volume open for drawing, frame after frame. It keeps the values that a frame's chain
// shares with the last one's, and the levels of memory beneath.
//
//   TimeStep -> Look -> VisibleBlocks -> FramePlan -> DrawOrder -> FrameRun -> Picture
//
// Reading order: this header, then frame.cpp, whose last function is that line. Used on one thread,
// the device's; workers run inside the calls.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/index/index_file.h"
#include "src/index/stale_check.h"
#include "src/render/blocks/losses/lost_tally.h"
#include "src/render/blocks/losses/spread_tally.h"
#include "src/render/frame/frame_run.h"
#include "src/render/light/arriving_light.h"
#include "src/render/session/planner.h"
#include "src/render/session/residency.h"
#include "src/volume/ranges/learnt_ranges.h"

namespace sluice {

// The numbers that come next in a trace.
struct TraceNumbers {
  int64_t frame = 0, chunk = 0;
};

struct SessionOptions : ResidencyOptions {
  bool lit = false;  // frames are shaded; the layout has a ghost layer
  // With Partition::kBoxes, frames may draw growing boxes. They are kept with the volume's index,
  // in these places.
  IndexPlaces index_places;
  // The numbers from which a trace goes on that an earlier session recorded. Chunks get new names,
  // since nothing is resident any more.
  TraceNumbers trace_from;
};

class Session {
 public:
  // The step's source, the device and the pool must outlive the session. Throws Error when the
  // memory is too little.
  Session(const TimeStep& step, Device& device, WorkerPool& pool, const SessionOptions& options);

  // The step that frames show from now on. A change costs the values to the right of it in the
  // chain, and the chunks that these change. Requires: the source and the layout of blocks are the
  // session's.
  void setTimeStep(const TimeStep& step);
  // Requires: a ghost layer for one that looks at gradients, as composite frames do.
  void setTransferFunction(TransferFunction transfer);
  void setOptions(const FrameOptions& options) { options_ = options; }
  // Sets the chooser of the blocks; null: classification. It must outlive its use.
  void chooseBlocksBy(BlockChooser* chooser) { planner_.chooseBlocksBy(chooser); }
  // Writes each request of the texture cache there too from now on; null: no longer. It must
  // outlive the frames drawn.
  void recordTo(TraceWriter* trace) { trace_ = trace; }
  // The session that takes this one's place goes on from these numbers.
  TraceNumbers nextInTrace() const { return {frame_number_, residency_.names().count()}; }
  // The step that the frame after the next one will show. Its data is read while the last part of
  // the next frame is drawn, as far as the buffers have room. Applies to the next frame alone.
  void expectAfterwards(const TimeStep& step) {
    expectBlocksOf(step);
    afterwards_ = step;
  }
  // The next frame is drawn as if it were the first; the levels keep their contents. `updates`
  // gives the first numbers of opacity map updates, and how they adapt.
  void forgetLastFrame(const UpdateCountOptions& updates = FrameLessons::kUpdates) {
    lessons_ = {};
    lessons_.updates = UpdateCount(updates);
  }

  // Draws. Throws Error, and Interrupted when FrameOptions::stop asks for it; the next frame is
  // right anyway. Requires: a transfer function is set.
  Frame frame();
  // The values that the next frame would be drawn from, for a frame that shows several sessions as
  // one medium (blended_frame.h). It is without occlusion, surfaces and pre-integration.
  struct Part {
    Session* session = nullptr;
    TimeStep step;
    LookPtr look;
    VisibleBlocksPtr visible;
    FramePlanPtr plan;
    FrameOptions options;
    bool lit = false;
    double last_draw_s = 0;        // the drawing time of the last frame
    TraceWriter* trace = nullptr;  // see recordTo()
    int64_t number = 0;            // of the frame, in a trace
  };
  struct Parts {
    std::vector<Part> of_sessions;
    TexturePlanPtr all;  // the blocks of all, whose clusters are those of the parts' plans
    double classify_s = 0, plan_s = 0;
  };
  // Requires: the sessions' volumes have one grid and one block size, and either the options of all
  // draw a cut, through the levels that they have in common (levelsInCommon()), or none.
  static Parts parts(std::span<Session* const> sessions);
  Residency& residency() { return residency_; }
  // A part was drawn. Adds to its report what the levels tell of the blocks. `reading_s`: the time
  // that took to read the blocks of all parts, `read_bytes` of them.
  void noteDrawn(const Part& part, double draw_s, double reading_s, uint64_t read_bytes,
                 FrameReport& report);
  // The report of the next frame if no block shows anything in it, so that it need not be drawn;
  // nullopt: it has to be. The planner keeps what it found for the frame.
  std::optional<FrameReport> withoutBlocks();
  // Whether all boxes of the next frame can be drawn together at its end (added_frames.h): nothing
  // has to be read for it, and nothing is asked of it while it is drawn. The planner keeps what it
  // found for the frame.
  bool canDrawAtEnd();
  // The time that the last frame's boxes took, which were drawn after its end.
  void noteDrawnAtEnd(double draw_s) { lessons_.draw_s += draw_s; }
  // The next frame is not drawn, but it counts in the numbers of frames that traces have.
  void passFrame() { ++frame_number_; }
  // Draws as frame() does if the picture is not wanted: its memory serves the next one.
  FrameReport frameReport();

  // Voxels of these blocks of any step, through level 2 like those of frames. Throws as
  // VolumeBuffer::acquire() does.
  std::vector<VolumeBlockPtr> readBlocks(std::span<const BlockName> keys) {
    return residency_.blocks().acquire(keys);
  }
  // The ranges of the finest level of the step that the session began with, with the blocks that
  // pictures have read; null: all of them were known.
  std::shared_ptr<const SliceRanges> learntRanges() const;
  // The blocks that the last frame found to be visible; null if there was no frame or they are out
  // of date.
  VisibleBlocksPtr lastVisible() const { return visible_.lock(); }

  CacheCounters volumeBufferCounters() const { return residency_.blocks().counters(); }
  CacheCounters textureBufferCounters() const { return residency_.chunks().counters(); }
  const TextureCache& textureCache() const { return residency_.cache(); }
  const PageGeometry& page() const { return opened_with_.page; }

 private:
  // The ranges of the step's finest level with those that pictures have learnt.
  std::shared_ptr<const SliceRanges> ranges() const;

  struct UnionKey {
    std::vector<Identity<VisibleBlocks>> visible;
    Algorithm algorithm;
    MergeOrder merge_order;
    int64_t time;
    Box3 crop;
    friend bool operator==(const UnionKey&, const UnionKey&) = default;
  };
  struct BoxesKey {
    TimeStep step;
    Identity<Look> look;
    Identity<FramePlan> plan;
    double step_vox;
    friend bool operator==(const BoxesKey&, const BoxesKey&) = default;
  };

  // The links of frame()'s chain that depend on more than the planner's values.
  //
  // The blocks that the frame draws. Drops the time limit from `options` if the blocks are chosen
  // so that all of them come in time. Adds to `judged` what was read to choose them.
  VisibleBlocksPtr blocksOf(const LookPtr& look, FrameOptions& options, ReadTally& judged);
  // Sets the distance between slices in `options`, and returns the rays through a pixel.
  PixelRays setSampling(const LookPtr& look, const VisibleBlocks& visible,
                        FrameOptions& options) const;
  // The device's values for a frame, without its light.
  FrameSetup setupOf(const Look& look, const View& view, const FrameOptions& options) const;
  // The light that arrives in the volume; null if all of it does, or the frame is not lit.
  LightVolumePtr lightFor(const FrameSetup& setup, const LookPtr& look,
                          const VisibleBlocks& visible, const View& view,
                          const FrameOptions& options);
  // Draws one picture for each ray through a pixel, and keeps the ray that each pixel shows. All of
  // them see the same boxes, so the first one's report holds what was read.
  Frame drawRays(const FrameValues& values, const PixelRays& rays);

  // Blocks of the step are compared with its ranges as they are read.
  void expectBlocksOf(const TimeStep& step);
  // Takes over the ranges that were learnt since the last frame.
  void takeLearntRanges();
  // Begins to read the data that `next` needs.
  void readAfterwards(const TimeStep& next);
  // Returns the limit of a picture of a cut with a time limit. Nullopt: the picture waits for all
  // its data, or leaves some out if it is of one level.
  std::optional<ReadLimit> readLimit(const LookPtr& look) const;
  // The distance between slices, see FrameOptions::step_follows_cut.
  double stepForCut(const VisibleBlocks& visible, const FrameOptions& options) const;
  // Ends a frame of these blocks: they are the last ones, and the report gets their spreads.
  void noteDrawn(const VisibleBlocksPtr& visible, double reading_s, uint64_t read_bytes,
                 FrameReport& report);
  // Whether a frame draws surfaces from coarser levels, whose blocks are then judged (LostTally).
  bool judgesSurfaces(const LookPtr& look, const FrameOptions& options) const;
  // Whether a coarser block loses part of a surface; reads it unless that is known, which is added
  // to the tally. Throws as VolumeBuffer::acquire() does.
  bool losesSurface(const ObjectBlock& object, ReadTally& tally);
  // Sets the count of thin blocks in a report by what the blocks lose, as far as they were read.
  void countLost(const Look& look, const VisibleBlocks& visible, const View& view, ReadTally& tally,
                 FrameReport& report);
  // Null if object boxes are drawn.
  ChosenBoxesPtr boxesOf(const LookPtr& look, const FramePlanPtr& plan);

  Device& device_;
  WorkerPool& pool_;
  const SessionOptions opened_with_;
  Memo<TimeStep, BoxStore> box_store_;
  const std::unique_ptr<StaleCheck> stale_check_;  // checks the blocks that residency_ reads
  const std::unique_ptr<SpreadTally> spreads_;     // notes their spreads
  const std::unique_ptr<LostTally> lost_;          // judges them if surfaces are drawn
  const std::unique_ptr<LearntRanges> learnt_;     // notes their ranges; null: all are known
  Residency residency_;
  Planner planner_;
  ArrivingLight light_;
  Memo<BoxesKey, const ChosenBoxes> boxes_;
  Memo<UnionKey, const TexturePlan> union_;  // of parts of which this session's is the first
  TimeStep step_;
  std::optional<TimeStep> afterwards_;
  std::unique_ptr<ReadAhead> read_afterwards_;
  TransferPtr transfer_;
  FrameOptions options_;
  std::weak_ptr<const VisibleBlocks> visible_;
  VisibleBlocksPtr drawn_;      // blocks of the last picture, if that was of a cut
  double bytes_per_s_ = 150e6;  // expected of reading, decoding and copying blocks
  TraceWriter* trace_ = nullptr;
  int64_t frame_number_;
  FrameLessons lessons_;
};

}  // namespace sluice
