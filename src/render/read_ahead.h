// ReadAhead: the texels of a frame's chunks, filled ahead of the draw in the order of the visit.
//
// A frame is cut into steps, each a share of a cluster that takes at most a quarter of the texture
// buffer; while one is drawn the next ones are read, decompressed and copied by the workers, as far
// as the buffer has room. What is still to come when it is destroyed is cancelled. One thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cache/texture_cache.h"
#include "src/texture/texture_buffer.h"
#include "src/texture/texture_plan.h"

namespace sluice {

class ReadAhead {
 public:
  using Deadline = std::optional<std::chrono::steady_clock::time_point>;

  // Which chunks a frame draws from; empty functions say all. `now` is asked when a step is begun
  // and again when it is taken, and does not go from false to true. `soon` is a guess of what it
  // will say, asked when a step is begun ahead.
  struct Needs {
    std::function<bool(int64_t chunk)> now, soon;
  };
  // For the clusters of `order` (positions in plan.clusters). The plan, `names` (of its chunks),
  // the buffer and the cache must outlive it; the cache says what needs no texels.
  ReadAhead(TextureBuffer& buffer, const TexturePlan& plan, std::span<const uint64_t> names,
            const TextureCache& cache, std::span<const int64_t> order, Needs needs = {});
  ~ReadAhead();
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  struct Step {
    int64_t cluster = 0;            // position in plan.clusters
    std::vector<int64_t> chunks;    // positions in plan.chunks, those that are needed
    bool completes_cluster = true;  // the last of its cluster's steps
  };
  // Texels of step.chunks, in that order; null where the cache held the chunk when the step was
  // begun, and where they are not there by the deadline.
  struct Taken {
    Step step;
    std::vector<ChunkTexelsPtr> texels;
  };
  // The next step; nullopt behind the last. Throws Error and Interrupted as the texture buffer
  // does.
  std::optional<Taken> take(const Deadline& deadline);
  // Of a chunk that went from the cache after its step was begun.
  ChunkTexelsPtr takeOne(int64_t chunk);

 private:
  struct Begun {
    std::vector<int64_t> chunks;  // those that are filled
    TextureBuffer::BatchPtr batch;
  };
  // Chunks of the step that must be filled, as far as one step may fill.
  std::vector<int64_t> absent(const Step& step, bool ahead) const;
  uint64_t bytesOf(int64_t chunk) const;
  // Of the steps that follow steps_[step] in its cluster.
  std::vector<int64_t> soonAfter(size_t step) const;
  TextureBuffer::BatchPtr beginNow(std::span<const int64_t> chunks, std::span<const int64_t> soon);
  void beginNext(bool may_wait);
  std::vector<ChunkTexelsPtr> texelsOf(const Begun& begun, const Deadline& deadline);
  // Waits for what was begun and puts it where the step has its chunks.
  void putTexels(const Begun& begun, const Deadline& deadline, Taken& taken);

  TextureBuffer& buffer_;
  const TexturePlan& plan_;
  const std::span<const uint64_t> names_;
  const TextureCache& cache_;
  const Needs needs_;
  const uint64_t most_bytes_;                  // of a step, unless one chunk takes more
  std::deque<Step> steps_;                     // those to come
  std::deque<Begun> begun_;                    // of the first of steps_
  std::vector<TextureBuffer::BatchPtr> late_;  // not filled at their deadline
};

}  // namespace sluice
