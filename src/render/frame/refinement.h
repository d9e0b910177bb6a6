// Refinement: a frame of a volume with several levels as a row of whole pictures, each better than
// the one before.
//
// The first picture shows all at the coarsest level, which takes no time worth mentioning. Each
// further one is an ordinary frame of a finer cut, down to the cut that the frame's options ask
// for. Nothing that is resident is thrown away for something coarser, since cuts only become finer.
// With a time limit, the cut of a picture that would take too long is refined front to back only as
// far as the time seems to allow; a picture that is not whole in time is no picture. One thread,
// the session's.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "src/base/threads/deadline.h"
#include "src/base/threads/worker_pool.h"
#include "src/render/blocks/level_cut.h"
#include "src/render/session/session.h"

namespace sluice {

// The volume and how it looks, for planning.
struct RefinedVolume {
  TimeStep step;  // the session's
  const TransferFunction& transfer;
  WorkerPool& pool;
};

class Refinement {
 public:
  // The distance between slices for a cut.
  using StepOf = std::function<double(const CutOptions&)>;

  // `session` and what `volume` refers to must outlive it. `frame`: the options of the last and
  // best picture; its time limit does not count, `until` does. Requires: frame.cut is set, several
  // levels.
  Refinement(Session& session, const RefinedVolume& volume, const FrameOptions& frame,
             StepOf step_of, std::optional<Deadline::TimePoint> until);
  // The session's blocks are chosen as before.
  ~Refinement();
  Refinement(const Refinement&) = delete;
  Refinement& operator=(const Refinement&) = delete;

  // The next better picture. Its report says whether it is the last (CutSummary::is_final).
  // nullopt: there is no better one, or the time is over; the first picture comes whatever the
  // time. Throws what Session::frame() does.
  std::optional<Frame> next();
  // Options of the picture that next() gave last.
  const FrameOptions& shown() const { return shown_; }

 private:
  // A cut as it was planned.
  struct Planned : BlockChooser {
    VisibleBlocksPtr choose(const BlockQuestion& /*question*/) override { return blocks; }
    FrameOptions options;
    VisibleBlocksPtr blocks;
    uint64_t bytes = 0;  // their voxels
  };

  Planned plan(const CutOptions& cut);
  std::optional<Planned> better();
  // Passes over cuts that make the same picture as the last one.
  void skipSame();
  bool isLast() const { return tried_ == cuts_.size(); }

  Session& session_;
  const RefinedVolume volume_;
  const FrameOptions frame_;
  const StepOf step_of_;
  const LookPtr look_;
  LevelCut chooser_;
  Deadline deadline_;
  std::vector<CutOptions> cuts_;  // of all pictures, the coarsest first
  size_t tried_ = 0;              // cuts that were drawn or are no better than a drawn one
  bool is_over_ = false;
  FrameOptions shown_;
  VisibleBlocksPtr blocks_;          // of the last picture; null: there is none
  uint64_t bytes_ = 0;               // their voxels
  double frame_s_ = 0, draw_s_ = 0;  // time of the last picture, and its part that was drawing
};

}  // namespace sluice
