// Scene: a volume that is ready to be drawn: its device, session and look, and their shares of the
// memory. The public Renderer and the commands of the program both draw through it.
//
// A picture may show several channels of the volume. Each is a layer: a source of its own with its
// look and session, drawn as an ordinary frame from the same camera. The picture is the sum of the
// layers' pictures (added_pictures.h), or one in which all layers are blended sample by sample
// (blended_frame.h). The memory is shared out evenly among the layers. If several ranks draw, they
// share out the blocks of each layer and compose each layer's picture, and rank 0 adds these. Of
// layers that are blended, a rank has the same blocks, and the blended picture is composed.
//
// The parts of a scene lie beside it: the look (chosen_look.h), the device (device_choice.h), the
// memory (resources.h), the layers' shares (channel_shares.h) and the place of a second volume
// (shared_world.h).
//
// Used on one thread, the device's; workers of the pool run inside the calls.
#pragma once

#include <sluice/options.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cache/trace/trace.h"
#include "src/base/error.h"
#include "src/device/pictures/added_frames.h"
#include "src/library/drawing/cost/picture_memory.h"
#include "src/library/drawing/scene/channel_shares.h"
#include "src/library/drawing/scene/chosen_look.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/opening/indexed_volume.h"
#include "src/parallel/compositing.h"
#include "src/parallel/rank_share.h"
#include "src/render/session/session.h"

namespace sluice {

// The part of a layer in a frame.
struct LayerFrame {
  FrameReport report;  // the sum of all strips
  bool shows_something = false;
};

// A frame that was drawn.
struct SceneFrame {
  FrameReport report;              // the sum of all strips and layers
  std::vector<LayerFrame> layers;  // of the scene, in their order
  VisibleBlocksPtr blocks;         // of the first layer that shows something
  bool shows_something = false;
  std::optional<Frame> whole;  // set only if the picture was drawn whole
};

// The parts that a scene is made of.
struct SceneInputs {
  std::shared_ptr<WorkerPool> pool;
  std::shared_ptr<const IndexedVolume> volume;
  // Further channels that pictures show together with it, opened in the same way.
  std::vector<std::shared_ptr<const IndexedVolume>> more = {};
  MachineOptions machine;
  // The ranks that draw its pictures together, which must outlive the scene; null: alone.
  Team* team = nullptr;
  // The boxes of the volume that these ranks have; null: each can read all of it.
  std::shared_ptr<const LentBoxes> lent = nullptr;
  // The look may become a lit one, for which the volume was indexed with gradients.
  bool may_be_lit = false;
};

// The bytes that others hold of so much memory for each layer.
using MoreBytes = std::function<uint64_t(uint64_t memory_bytes)>;
inline uint64_t noMoreBytes(uint64_t /*memory_bytes*/) {
  return 0;
}

// A channel of a scene.
struct Layer {
  Layer(std::shared_ptr<const IndexedVolume> of, MachineOptions share)
      : owned_volume(std::move(of)),
        volume(*owned_volume),
        machine(std::move(share)),
        page(volume.page) {}

  const std::shared_ptr<const IndexedVolume> owned_volume;
  const IndexedVolume& volume;
  const MachineOptions machine;  // memory_bytes is the layer's share
  PageGeometry page;             // with as many pages as the session has
  uint64_t part_bytes = 0;       // part of the share for a picture, or a strip or part of it
  // Part of the share for all that is held in addition to the levels: min-max arrays, plans,
  // pictures, and of a series its opacity functions and what culling keeps.
  uint64_t beside_bytes = 0;
  ChosenLook look;
  std::unique_ptr<RankShare> share;    // null: this process draws alone
  uint64_t uploaded_bytes = 0;         // to the device, for pictures of several layers
  std::unique_ptr<TraceWriter> trace;  // null: nothing is recorded
  TraceNumbers next_in_trace;          // after the session that was opened before
  std::unique_ptr<Session> session;    // null after a comparison took its memory
};

// The counters of levels 2 to 4, of all layers together. Peaks are sums of the layers' peaks.
struct LevelCounters {
  CacheCounters volume_buffer, texture_buffer, texture_cache;
  uint64_t pages = 0, pages_loaded = 0;
};

// The counters of a layer's session.
LevelCounters countersOf(const Session& session);

// A scene is its first layer, and perhaps more.
struct Scene : Layer {
  // Makes the device, and opens the session for frames like this one. A size of 0 x 0 leaves no
  // memory to pictures: the caller holds them. Throws Error.
  Scene(SceneInputs inputs, const LookArguments& look, const FrameOptions& frame);
  Scene(Scene&&) = default;
  // The sessions end before the device.
  ~Scene();

  // Opens the session anew, so that the levels leave room for the min-max arrays, pictures or parts
  // of them, a frame's plan and `more_bytes`. The contents of the earlier session are lost; a trace
  // goes on. Throws Error if the memory is too little.
  void openSession(const FrameOptions& frame, const MoreBytes& more_bytes);
  // The look of frames like this one. Throws Error from a transfer function's file, or for layers
  // that cannot be blended; the looks are the same then. The caller opens the session anew before
  // the next frame unless isOpen().
  void setLook(const LookArguments& look, const FrameOptions& frame);
  // The options of frames from now on, with the light of the first layer's look.
  void setOptions(const FrameOptions& options);
  // Chooses how the layers of such frames become one picture. The caller opens the session anew
  // before the next frame unless isOpen().
  void setCombining(const FrameOptions& frame);
  // The time step that frames show from now on, and the one after the next frame: of each layer.
  void setTimeStep(const std::vector<TimeStep>& steps);
  void expectAfterwards(const std::vector<TimeStep>& steps);
  // Blocks are chosen by this, or null by the classification; of several ranks each has its share.
  void chooseBlocksBy(BlockChooser* chooser);
  // The distance between slices, in voxels, of a picture for which nobody sets one: it follows from
  // the view and from the finest level in the picture. `steps`: of each layer.
  double chosenStep(const std::vector<TimeStep>& steps, const FrameOptions& options) const;
  // The steps that the layers were opened for.
  std::vector<TimeStep> openedSteps() const;
  // The options of `sluice render` that give the looks of all layers.
  std::string lookText() const;
  // The same for a frame, with its distance between slices, and with the options of its light that
  // the user set in `picture`, if they count.
  std::string lookOf(const FrameOptions& options, const PictureOptions& picture) const;
  // Whether frames with these options are pre-integrated. Labels and cuts through levels never are.
  bool integrates(const FrameOptions& options) const;

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
  // The next frame as one picture, for those who look at single frames. `of_layers`: set to the
  // layers' parts, unless null.
  Frame frame(std::vector<LayerFrame>* of_layers = nullptr);
  // The channels that show nothing in a frame that shows others, in one line: "channel 1 (GFP)
  // shows nothing: ..."; empty if all show something.
  std::string emptyLayers(const SceneFrame& frame, int64_t time, const FrameOptions& options,
                          const IndexPass& pass) const;
  // Lines about options of the looks that do not do what they say. With several layers, each names
  // its channel.
  std::vector<std::string> lookWarnings() const;
  // standInNotes() of the layers' volumes.
  std::vector<std::string> standInNotes() const;
  // The reason why a frame shows nothing, in one line; empty if it shows something.
  std::string whyNothing(const SceneFrame& frame, int64_t time, const FrameOptions& options,
                         const IndexPass& pass) const;

  // Records the requests to the texture caches in the files of tracePaths() from now on; empty:
  // finishes the files. The files of a scene that ends before are left out. Throws Error.
  void recordTo(const std::string& path);
  // The trace of each layer if this one is asked for, see channelTraces().
  std::vector<std::string> tracePaths(const std::string& path) const;
  // Throws Error if a file of several channels, whose names nobody has given, is there and is no
  // trace.
  void requireNoOtherFiles(const std::string& path) const;

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

  // The counters of all layers.
  LevelCounters levelCounters() const;
  // Bytes of files that all layers have read.
  uint64_t storedBytesRead() const;
  // The layers, the first one included.
  std::vector<const Layer*> layers() const;
  std::vector<Layer*> layers();
  // Whether its layers are blended.
  bool blends() const { return sluice::blends(combine, 1 + more.size()); }
  // Whether the session is open, with pages for layers that are combined as they are now.
  bool isOpen() const { return session != nullptr && opened_to_blend_ == blends(); }
  std::vector<const ShownChannel*> shownChannels() const;
  std::vector<LayerLook> looks() const;
  // "not 3; give one --channel", for messages about several layers.
  std::string notOneChannel() const;
  // The options of a layer's frames, of those that setOptions() got.
  FrameOptions optionsOf(const Layer& layer, const FrameOptions& options) const;

  const std::shared_ptr<WorkerPool> owned_pool;
  WorkerPool& pool;
  const bool may_be_lit;
  const uint64_t memory_bytes;        // of all layers
  LookArguments asked;                // the look of all layers
  Combine combine = Combine::kAdd;    // combineOf() the layers
  std::string why_added;              // addedNote() of them
  std::string drawn_look;             // lookOf() the frames that are drawn, for whoever keeps it
  uint64_t peak_anonymous_bytes = 0;  // at the calls of noteMemory()
  CompositingReport composited;       // with several ranks: of the last frame, all layers
  std::unique_ptr<Device> device;
  std::vector<std::unique_ptr<Layer>> more;  // the further layers; their sessions end first

 private:
  bool opened_to_blend_ = false;  // the session that was opened last

  // Makes the layer's share of what these ranks draw.
  void shareAmong(Team& team, std::shared_ptr<const LentBoxes> lent, Layer& layer,
                  const FrameOptions& frame);
  // The memory that a picture takes, whole or in strips.
  PictureDemand demandOf(const FrameOptions& frame) const;
  // The shares of the layers if all of them had so much memory together.
  std::vector<BesideShare> sharesOf(const FrameOptions& frame, const MoreBytes& more_bytes,
                                    uint64_t of_memory) const;
  // The bytes that the sessions need of so much memory.
  uint64_t needOfMemory(const FrameOptions& frame, const MoreBytes& more_bytes,
                        uint64_t of_memory) const;
  // The memory with which ranks draw any picture of the frame's size, at least `least_bytes`.
  uint64_t enoughForRanks(const FrameOptions& frame, const MoreBytes& more_bytes,
                          uint64_t least_bytes) const;
  void openSession(Layer& layer, Partition partition);
  // The layer's next frame, composed.
  Frame nextFrame(Layer& layer);
  // The frame that `draw_own` draws. With several ranks, it draws the layer's share of it, and rank
  // 0 gets the picture that all have composed.
  Frame composed(Layer& layer, const std::function<Frame()>& draw_own);
  // The reports of the layers of which no block shows anything, on all ranks alike; nullopt for
  // those that have to be drawn.
  std::vector<std::optional<FrameReport>> layersWithoutBlocks();
  // The device if it can draw the next frames of all layers that have blocks together; null: each
  // has to be drawn alone.
  AddsFrames* addsTogether(const std::vector<std::optional<FrameReport>>& without_blocks);
  // The sum of the layers' next frames.
  Frame drawLayers(std::vector<LayerFrame>& parts);
  // The layers' next frame, blended.
  Frame drawBlended(std::vector<LayerFrame>& parts);
  // The same of the only layer that has blocks; of the others, the reports.
  Frame drawOnly(const std::vector<std::optional<FrameReport>>& without_blocks,
                 std::vector<LayerFrame>& parts);
};

// The distance between slices of a volume by itself: half a voxel if a pixel is smaller than a
// voxel, because the picture shows the difference then.
double stepFor(const View& view, const VolumeLayout& layout);

}  // namespace sluice
