// Refinement: a frame of volumes with several levels as a row of whole pictures, each better than
// the one before.
//
// The first picture shows all at the coarsest level, which takes no time worth mentioning. Each
// further one is an ordinary frame of a finer cut, down to the cut that the frame's options ask
// for. Nothing that is resident is thrown away for something coarser, since cuts only become finer.
// With a time limit, the cut of a picture that would take too long is refined front to back only as
// far as the time seems to allow; a picture that is not whole in time is no picture.
//
// A picture may show several volumes (layers), which become finer together. One without a cut, such
// as a volume of one level, is drawn as it is in every picture. One thread, the sessions'.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "src/base/threads/deadline.h"
#include "src/base/threads/worker_pool.h"
#include "src/render/blocks/cut/level_cut.h"
#include "src/render/session/session.h"

namespace sluice {

// A volume of the picture and how it looks, for planning.
struct RefinedLayer {
  Session& session;
  TimeStep step;  // the session's
  const TransferFunction& transfer;
  // The last picture shows its finest level without a cut: nobody asked for one but the row.
  // Requires: the row has no time limit, since the bytes of a picture without a cut are not
  // counted.
  bool ends_uncut = false;
};

// How the layers become one picture.
struct RefinedPainter {
  // The distance between slices for a cut, or without one.
  std::function<double(const std::optional<CutOptions>&)> step_of;
  // The options of a layer, by its place, for a picture with these options.
  std::function<FrameOptions(size_t, const FrameOptions&)> options_of;
  // The layers are one medium, of which all are drawn from one cut (LevelCut::chooseTogether());
  // otherwise each has its own.
  bool is_one_medium = false;
  // Draws the next frame of all sessions. Throws what Session::frame() does.
  std::function<Frame()> draw;
};

class Refinement {
 public:
  // The sessions, what `layers` and `painter` refer to, and the pool must outlive it. `frame`: the
  // options of the last and best picture; its time limit does not count, `until` does. Requires:
  // frame.cut is set, and a layer is drawn from a cut.
  Refinement(const std::vector<RefinedLayer>& layers, RefinedPainter painter,
             const FrameOptions& frame, std::optional<Deadline::TimePoint> until, WorkerPool& pool);
  // The sessions' blocks are chosen as before.
  ~Refinement();
  Refinement(const Refinement&) = delete;
  Refinement& operator=(const Refinement&) = delete;

  // The next better picture. nullopt: there is no better one, or the time is over; the first
  // picture comes whatever the time. Throws what the painter does.
  std::optional<Frame> next();
  // Options of the picture that next() gave last.
  const FrameOptions& shown() const { return shown_; }
  // Whether that picture is the one that the frame's options ask for.
  bool isBest() const { return !is_over_ && isLast(); }

 private:
  // A layer's part of a planned picture.
  struct Part : BlockChooser {
    VisibleBlocksPtr choose(const BlockQuestion& /*question*/) override { return blocks; }
    FrameOptions options;
    VisibleBlocksPtr blocks;  // null: the layer is drawn without a cut
    uint64_t bytes = 0;       // their voxels
  };
  struct Planned {
    FrameOptions options;
    std::vector<Part> parts;  // of the layers, in their order
    uint64_t bytes = 0;
  };
  // A layer in the row.
  struct Layer {
    RefinedLayer of;
    bool has_cut = false;
    LookPtr look;
    LevelCut chooser;
    VisibleBlocksPtr blocks;  // of the last picture
    uint64_t bytes = 0;       // their voxels
  };

  // `growth`: the share of what each layer wants to read in addition to the last picture's blocks;
  // null: all.
  Planned plan(const CutOptions& cut, const double* growth = nullptr);
  // Chooses the blocks of a picture, of which the layers' options are set.
  void choose(Planned& planned);
  std::optional<Planned> better();
  bool showsAsLast(const Planned& planned) const;
  // Passes over cuts that make the same picture as the last one.
  void skipSame();
  bool isLast() const { return tried_ == cuts_.size(); }
  void chooseAsBefore();

  const RefinedPainter painter_;
  const FrameOptions frame_;
  Deadline deadline_;
  std::vector<std::unique_ptr<Layer>> layers_;
  std::vector<CutOptions> cuts_;  // of all pictures, the coarsest first
  size_t tried_ = 0;              // cuts that were drawn or are no better than a drawn one
  bool is_over_ = false;
  bool has_picture_ = false;
  FrameOptions shown_;
  uint64_t bytes_ = 0;               // voxels of the last picture's blocks
  double frame_s_ = 0, draw_s_ = 0;  // time of the last picture, and its part that was drawing
};

}  // namespace sluice
