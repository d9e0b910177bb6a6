// Session: a volume open for drawing. It owns levels 2 to 4 and carries what stays the same from
// frame to frame: blocks, chunks, the classification and the plan while nothing changes them.
//
// Reading order: this header, then frame.cpp, whose one function is the frame. One thread, the
// device's; workers run inside the calls.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "cache/texture_cache.h"
#include "cache/trace.h"
#include "src/base/worker_pool.h"
#include "src/classify/box_store.h"
#include "src/render/drawn_boxes.h"
#include "src/render/frame_occlusion.h"
#include "src/render/frame_options.h"
#include "src/render/frame_setup.h"
#include "src/render/read_ahead.h"
#include "src/texture/chunk_names.h"
#include "src/texture/texture_buffer.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

struct SessionOptions {
  PageGeometry page;          // bytes_per_voxel that of the volume's device form
  uint64_t memory_bytes = 0;  // of levels 2 and 3, and of level 4 on a software device
  PolicyKind policy = PolicyKind::kLru;
  uint64_t seed = 1;  // of the random policy
  bool lit = false;   // frames are shaded; the layout has a ghost layer
  // kBoxes: frames may draw growing boxes, and a share of the memory is theirs. They are kept with
  // the index of the volume of this name.
  Partition partition = Partition::kBlocks;
  std::string volume_name;
};

// How --memory is shared out (design, point 3).
struct Budgets {
  uint64_t volume_buffer = 0, texture_buffer = 0, texture_cache = 0;
  uint64_t scratch = 0;  // of the threads that read
  uint64_t source = 0;   // of chunks that the source holds decoded
  uint64_t boxes = 0;    // growing boxes
  uint64_t growing = 0;  // voxels that they are made of
  int readers = 1;       // threads that read and copy beside the one that draws
};
// What takes memory beside the textures.
struct BufferNeeds {
  int64_t block_vox = 64;            // a side
  uint64_t source_thread_bytes = 0;  // VolumeSource::heldBytesAThread()
  uint64_t growing_bytes = 0;        // of a block (volume_boxes.h); 0: no growing boxes are drawn
};
BufferNeeds bufferNeeds(const VolumeSource& source, const BlockLayout& layout, Partition partition);
// The least that levels 1 to 3 work with: two merged chunks, and for one reader and the thread that
// draws two blocks each, their scratch, what the source holds for them and what they grow boxes of.
uint64_t leastBufferBytes(const PageGeometry& page, const BufferNeeds& needs);
// What level 4 takes of --memory: the cache and the textures that may wait beside it.
uint64_t textureMemoryBytes(const PageGeometry& page, bool textures_in_memory);
// Up to `most_readers` readers, fewer where memory is short. Throws Error, with the least that
// works, when level 4 leaves too little to the others.
Budgets shareMemory(uint64_t memory_bytes, const PageGeometry& page, bool textures_in_memory,
                    const BufferNeeds& needs, int most_readers);

// Seconds of wall clock, but read, decode and copy: summed over all threads that did it.
struct StageSeconds {
  double classify = 0, plan = 0, read = 0, decode = 0, copy = 0, upload = 0, draw = 0;
  double boxes = 0;  // growing boxes: made or read from the index, and those to draw chosen
};

// See the fields of the same names in FrameReport.
struct MovedBytes {
  uint64_t decoded = 0, copied = 0, uploaded = 0;
};

struct BlockClasses {
  int64_t white = 0, grey = 0, black = 0;
};

struct FrameReport {
  double seconds = 0;
  StageSeconds stages;
  // When counted: samples in the boxes that were drawn, and those that the device took of them,
  // fewer where rays end early and pixels are stopped (with depth: not counted, all).
  uint64_t samples_drawn = 0, samples_taken = 0;
  uint64_t samples_object = 0;  // of them or not, those inside object boxes
  int64_t boxes_drawn = 0;      // handed to the device
  int64_t white = 0, grey = 0, black = 0;
  BlockClasses before;                          // of the last frame; all 0 for the first
  int64_t clusters = 0, chunks = 0, pages = 0;  // of the plan
  // By this frame.
  uint64_t pages_loaded = 0, binds = 0;
  uint64_t decoded_bytes = 0;   // voxels into the volume buffer
  uint64_t copied_bytes = 0;    // voxels into the texture buffer
  uint64_t uploaded_bytes = 0;  // whole pages into the texture cache
  MovedBytes rebuild;           // what a frame moves that starts from nothing
  // Of the cells that can be seen, those left out at the time limit. 0: the picture is complete.
  double missing_share = 0;
  OcclusionReport occlusion;  // of a frame with occlusion
};

// What was drawn between two updates of the opacity map (Li 2003, Figure 8).
struct FramePhase {
  Picture picture;                // of these boxes alone, as far as their chunks are still resident
  std::optional<OpacityMap> map;  // that they were held against; none before the first update
};

struct Frame {
  Picture picture;
  FrameReport report;
  std::vector<FramePhase> phases;  // where they are kept
};

class Session {
 public:
  // Where the numbers of map updates begin. The paper's machine took 9; on software GL each update
  // waits for the slowest of its threads, and 2 to 3 gave the shortest frames.
  static constexpr UpdateCountOptions kUpdates{.first = 3};

  // All references must outlive the session. `ranges` are of time step `time` of `source` in its
  // block layout.
  Session(VolumeSource& source, int64_t time, const SliceRanges& ranges, Device& device,
          WorkerPool& pool, const SessionOptions& options);
  ~Session();

  // A changed transfer function costs a classification and the chunks that it changes. Requires: a
  // layout with a ghost layer for one that looks at gradients, which composite frames do.
  void setTransferFunction(const TransferFunction& transfer);
  // Everything else of a frame.
  void setOptions(const FrameOptions& options);
  // Of these the camera alone.
  void setCamera(const Camera& camera) { frame_options_.camera = camera; }
  // From now on each request of the texture cache is written there too; null: no longer. It must
  // outlive the frames drawn.
  void recordTo(TraceWriter* trace) { trace_ = trace; }
  // Draws. Throws Error. Requires: a transfer function is set.
  Frame frame();
  // The same where the picture is not wanted: its memory serves the next one.
  FrameReport frameReport();

  CacheCounters volumeBufferCounters() const { return blocks_.counters(); }
  CacheCounters textureBufferCounters() const { return chunks_.counters(); }
  const TextureCache& textureCache() const { return cache_; }
  const PageGeometry& page() const { return options_.page; }

 private:
  // The frame and its stages, in order; frame.cpp tells the story.
  Frame drawFrame();
  void classifyBlocks(FrameReport& report);
  void planChunks(FrameReport& report);
  void makeResident(const ReadAhead::Taken& taken, FrameReport& report);
  // `texels` may be null when the chunk is resident.
  void requestChunk(int64_t position, int64_t cluster_position, const ChunkTexels* texels,
                    FrameReport& report);
  // Positions in the plan's blocks, front to back, whose chunks were asked for.
  void drawBlocks(std::span<const int64_t> order, const EyePosition& eye, FrameReport& report);
  void drawBlock(int64_t position, const EyePosition& eye, FrameReport& report);
  // Draws the box, or what is not hidden of it, with those that follow it in its chunk.
  void drawBox(int64_t chunk, BoxDraw box, FrameReport& report);
  void flushBoxes(FrameReport& report);
  void countSamples(FrameReport& report);
  // Rays or pixels may stop in this frame, so that fewer samples are taken than lie in its boxes.
  bool countsTaken() const {
    return frame_options_.count_samples && frame_options_.mode == Mode::kComposite &&
           !frame_options_.with_depth && rayThreshold(frame_options_) < 1;
  }
  // What is hidden, see frame_occlusion.h.
  void startOcclusion(const FrameSetup& setup, const EyePosition& eye);
  void updateOpacityMap(FrameReport& report);
  void finishOcclusion(FrameReport& report);
  // Draws each phase again by itself.
  std::vector<FramePhase> drawPhases(const FrameSetup& setup);
  bool isHidden(const Chunk& chunk) const;
  ReadAhead::Needs chunkNeeds();
  // Of a block of the plan; null where its growing boxes are not made and the frame does not wait
  // for them.
  std::shared_ptr<const DrawnBoxes> drawnBoxes(int64_t position);
  void dropDrawnBoxes();

  void dropPlan();
  // Until when a frame begun at `begin` waits.
  ReadAhead::Deadline deadline(std::chrono::steady_clock::time_point begin) const;
  MovedBytes movedBytes() const;  // since construction
  MovedBytes rebuildBytes() const;
  Box3 crop() const;
  BoxDraw boxDraw(const TextureBlock& block) const;
  StageSeconds workerSeconds() const;

  VolumeSource& source_;
  const int64_t time_;
  const SliceRanges& ranges_;
  Device& device_;
  WorkerPool& pool_;
  const SessionOptions options_;
  const Budgets budgets_;
  VolumeBuffer blocks_;
  WorkerPool readers_;
  TextureBuffer chunks_;
  TextureCache cache_;
  ChunkNames chunk_names_;
  std::optional<BoxStore> box_store_;
  const uint64_t first_id_;  // of the device's ids, ours

  TraceWriter* trace_ = nullptr;
  int64_t frame_number_ = 0;
  FrameOptions frame_options_;
  std::optional<TransferFunction> transfer_;
  // Kept until what they follow from changes.
  std::optional<OpacityTable> table_;
  std::optional<Classification> classification_;
  std::optional<TexturePlan> plan_;
  std::vector<uint64_t> names_;  // ids of plan_->chunks
  std::optional<ReadAhead> ahead_;
  // By position in plan_->blocks, as far as the budget goes.
  std::unordered_map<int64_t, std::shared_ptr<const DrawnBoxes>> drawn_boxes_;
  uint64_t drawn_boxes_bytes_ = 0;
  // Drawn next, in one chunk.
  struct PendingBoxes {
    int64_t chunk = 0;
    std::vector<BoxDraw> boxes;
  };
  PendingBoxes pending_;
  std::vector<BoxDraw> counted_;  // the frame's boxes, where its samples are to be counted
  struct Phase {
    std::optional<OpacityMap> map;
    std::vector<PendingBoxes> drawn;
  };
  std::vector<Phase> phases_;  // of the frame, where they are kept
  std::optional<FrameOcclusion> occlusion_;
  UpdateCount update_count_{kUpdates};
  // Chunks of the plan of which something was drawn: in this frame, and in the last one with
  // occlusion, empty before. What the last one hid is not read ahead.
  std::vector<bool> shown_, last_shown_;
  BlockClasses last_blocks_;
  double last_draw_s_ = 0;
};

}  // namespace sluice
