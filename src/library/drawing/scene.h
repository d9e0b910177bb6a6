// Scene: a volume that is ready to be drawn: its device, session and look, and their shares of the
// memory. The public Renderer and the commands of the program both draw through it.
//
// Used on one thread, the device's; workers of the pool run inside the calls.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cache/trace/trace.h"
#include "src/library/drawing/chosen_look.h"
#include "src/library/drawing/picture_memory.h"
#include "src/library/drawing/resources.h"
#include "src/library/opening/indexed_volume.h"
#include "src/parallel/rank_share.h"
#include "src/render/session/session.h"

namespace sluice {

// A frame that was drawn.
struct SceneFrame {
  FrameReport report;  // the sum of all strips
  VisibleBlocksPtr blocks;
  bool shows_something = false;
  std::optional<Frame> whole;  // set only if the picture was drawn whole
};

// The parts that a scene is made of.
struct SceneInputs {
  std::shared_ptr<WorkerPool> pool;
  std::shared_ptr<const IndexedVolume> volume;
  MachineOptions machine;
  // The ranks that draw its pictures together, which must outlive the scene; null: alone.
  Team* team = nullptr;
  // The look may become a lit one, for which the volume was indexed with gradients.
  bool may_be_lit = false;
};

struct Scene {
  // Makes the device, and opens the session for frames like this one. A size of 0 x 0 leaves no
  // memory to pictures: the caller holds them. Throws Error.
  Scene(SceneInputs inputs, const LookArguments& look, const FrameOptions& frame);

  // Opens the session anew, so that the levels leave room for the min-max arrays, pictures or parts
  // of them, a frame's plan and `more_bytes`. The contents of the earlier session are lost. Throws
  // Error if the memory is too little.
  void openSession(const FrameOptions& frame, uint64_t more_bytes);
  // Throws Error from a transfer function's file; the look is the same then.
  void setLook(const LookArguments& look, Mode mode);
  // Blocks are chosen by this, or null by the classification; of several ranks each has its share.
  void chooseBlocksBy(BlockChooser* chooser);
  // The distance between slices, in voxels, of a picture for which nobody sets one: it follows from
  // the view and from the finest level in the picture.
  double chosenStep(const TimeStep& step, const FrameOptions& options) const;
  // The options of `sluice render` that give the look of a frame.
  std::string lookOf(const FrameOptions& options) const;

  // Pictures that are too large for their share of the memory are drawn strip by strip, from the
  // top down. Strips share the plan and the contents of the levels; a strip reads and draws the
  // blocks that it shows. A single strip if pictures are drawn whole, as those of several ranks
  // are, which exchange parts of the whole.
  std::vector<PictureRows> stripsOf(const FrameOptions& frame) const;
  // Draws the next frame of the session and gives its rows to `take`, from the top down; the pixels
  // are the same in strips and whole. With several ranks, all call it and rank 0 gets the picture.
  // Throws Error, Interrupted and the errors of `take`; the device draws whole pictures again
  // afterwards.
  SceneFrame draw(const std::vector<PictureRows>& strips,
                  const std::function<void(const Picture& rows)>& take);
  // The next frame as one picture, for those who look at single frames.
  Frame frame();
  // The reason why a frame shows nothing, in one line; empty if it shows something.
  std::string whyNothing(const SceneFrame& frame, int64_t time, const FrameOptions& options,
                         const IndexPass& pass) const;

  // Records the requests to the texture cache in this file from now on; empty: finishes the file.
  // The file of a scene that ends before is left out. Throws Error.
  void recordTo(const std::string& path);

  // Runs `body`, with several ranks at rank 0 first, so that the files that it keeps are there for
  // the others.
  template <class Body>
  void inTurn(const Body& body) {
    if (share)
      share->inTurn(body);
    else
      body();
  }
  // Keeps the ranges of finest blocks that pictures have learnt (learnt_ranges.h) for later
  // commands.
  void keepLearntRanges() const;
  // After a frame: notes the process's own memory.
  void noteMemory();

  const std::shared_ptr<WorkerPool> owned_pool;
  const std::shared_ptr<const IndexedVolume> owned_volume;
  WorkerPool& pool;
  const IndexedVolume& volume;
  const MachineOptions machine;
  const bool may_be_lit;
  const uint64_t memory_bytes;
  PageGeometry page;        // with as many pages as the session has
  uint64_t part_bytes = 0;  // part of memory_bytes for a picture, or a strip or part of it
  // Part of memory_bytes for all that is held in addition to the levels: min-max arrays, plans,
  // pictures, and of a series its opacity functions and what culling keeps.
  uint64_t beside_bytes = 0;
  uint64_t peak_anonymous_bytes = 0;  // at the calls of noteMemory()
  std::unique_ptr<RankShare> share;   // null: alone
  std::unique_ptr<Device> device;
  ChosenLook look;
  std::unique_ptr<TraceWriter> trace;
  std::unique_ptr<Session> session;  // null after a comparison took its memory
};

// The bytes that a frame holds in addition to the levels and the picture: min-max arrays, plans.
uint64_t othersBytes(const IndexedVolume& volume, const TransferFunction& transfer,
                     const FrameOptions& frame, WorkerPool& pool);

}  // namespace sluice
