// ReadAhead: the texels of a frame's chunks, filled ahead of the draw in the order of the visit.
//
// A frame is cut into steps, each a share of a cluster that takes at most a quarter of the texture
// buffer's room. While a step is drawn, the workers read, decompress and copy the next ones, as far
// as the buffer has room. Steps that are still to come when it is destroyed are cancelled. Used by
// one thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "src/render/frame/draw_order.h"
#include "src/render/frame/frame_plan.h"
#include "src/render/session/residency.h"

namespace sluice {

class ReadAhead {
 public:
  using Deadline = std::optional<std::chrono::steady_clock::time_point>;

  // Which chunks a frame draws from; empty functions mean all. `now` is asked when a step is begun
  // and again when it is taken, and does not go from false to true. `soon` is a guess of its later
  // answer, asked when a step is begun ahead.
  struct Needs {
    std::function<bool(ChunkPosition chunk)> now, soon;
  };
  // Reads for the clusters of `order`, a visit of `plan`. `residency` must outlive it: its texture
  // buffer is filled for `purpose`, its texture cache tells which chunks need no texels.
  ReadAhead(Residency& residency, FramePlanPtr plan, const DrawOrder& order,
            ReadPurpose purpose = {}, Needs needs = {});
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  struct Step {
    ClusterPosition cluster;
    std::vector<ChunkPosition> chunks;  // needed chunks
    bool completes_cluster = true;      // the last of its cluster's steps
  };
  // Texels of step.chunks, in that order; null if the cache held the chunk when the step was begun,
  // and if they are not there by the deadline.
  struct Taken {
    Step step;
    std::vector<ChunkTexelsPtr> texels;
  };
  // Begins to read as much as there is room for, for a frame that comes later, and does nothing
  // else.
  void begin() { beginNext(false); }
  // Whether the last step was taken.
  bool isDone() const { return steps_.empty(); }
  // The next step; nullopt behind the last. Throws Error and Interrupted as the texture buffer
  // does.
  std::optional<Taken> take(const Deadline& deadline);
  // The texels of a chunk that was evicted from the cache after its step was begun.
  ChunkTexelsPtr takeOne(ChunkPosition chunk);

 private:
  // A batch that is being filled; cancelled unless it is finished.
  class Begun {
   public:
    Begun(TextureBuffer& buffer, std::vector<ChunkPosition> chunks, TextureBuffer::BatchPtr batch)
        : buffer_(&buffer), chunks_(std::move(chunks)), batch_(std::move(batch)) {}
    ~Begun() {
      if (batch_ != nullptr) buffer_->cancel(batch_);
    }
    Begun(Begun&&) = default;
    Begun& operator=(Begun&&) = delete;

    const std::vector<ChunkPosition>& chunks() const { return chunks_; }
    std::vector<ChunkTexelsPtr> finish() { return buffer_->finish(std::exchange(batch_, nullptr)); }
    std::vector<ChunkTexelsPtr> waitUntil(std::chrono::steady_clock::time_point deadline) {
      return buffer_->waitUntil(batch_, deadline);
    }

   private:
    TextureBuffer* buffer_;
    std::vector<ChunkPosition> chunks_;
    TextureBuffer::BatchPtr batch_;  // null: finished
  };
  // Chunks of the step that must be filled, as far as one step may fill.
  std::vector<ChunkPosition> absent(const Step& step, bool ahead) const;
  bool isHeld(ChunkPosition chunk) const;  // by the texture cache
  uint64_t bytesOf(ChunkPosition chunk) const;
  // The chunks of the steps that follow steps_[step] in its cluster.
  std::vector<ChunkPosition> soonAfter(size_t step) const;
  Begun beginNow(std::vector<ChunkPosition> chunks, std::span<const ChunkPosition> soon);
  std::optional<Begun> tryBegin(std::vector<ChunkPosition> chunks,
                                std::span<const ChunkPosition> soon);
  void beginNext(bool may_wait);
  // Waits for the batch and puts its texels at the step's chunks.
  void putTexels(Begun begun, const Deadline& deadline, Taken& taken);

  const Residency& residency_;
  TextureBuffer& buffer_;
  const FramePlanPtr plan_;
  const ReadPurpose purpose_;
  const Needs needs_;
  const uint64_t most_bytes_;  // limit of a step, unless one chunk takes more
  std::deque<Step> steps_;     // steps to come
  std::deque<Begun> begun_;    // batches of the first of steps_
  std::vector<Begun> late_;    // not filled at their deadline
};

}  // namespace sluice
