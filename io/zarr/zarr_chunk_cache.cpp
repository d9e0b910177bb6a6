#include "io/zarr/zarr_chunk_cache.h"

#include <algorithm>
#include <utility>

namespace sluice {

ChunkMemory::Buffer ChunkMemory::take(uint64_t bytes) {
  const MutexLock lock(mutex_);
  auto best = kept_.end();
  for (auto buffer = kept_.begin(); buffer != kept_.end(); ++buffer)
    if (buffer->size >= bytes && (best == kept_.end() || buffer->size < best->size)) best = buffer;
  if (best != kept_.end()) {
    Buffer found = std::move(*best);
    kept_.erase(best);
    return found;
  }
  // All too small: one of them makes way.
  if (!kept_.empty()) {
    now_ -= kept_.back().size;
    kept_.pop_back();
  }
  Buffer made{std::make_unique_for_overwrite<std::byte[]>(static_cast<size_t>(bytes)), bytes};
  now_ += bytes;
  peak_ = std::max(peak_.load(), now_.load());
  return made;
}

void ChunkMemory::give(Buffer buffer) {
  const MutexLock lock(mutex_);
  if (now_ <= limit_bytes_)
    kept_.push_back(std::move(buffer));
  else
    now_ -= buffer.size;
}

void ChunkMemory::setLimit(uint64_t limit_bytes) {
  const MutexLock lock(mutex_);
  limit_bytes_ = limit_bytes;
  while (!kept_.empty() && now_ > limit_bytes_) {
    now_ -= kept_.back().size;
    kept_.pop_back();
  }
}

ZarrChunkCache::ZarrChunkCache(uint64_t chunk_bytes, uint64_t budget_bytes, Decode decode)
    : chunk_bytes_(chunk_bytes),
      decode_(std::move(decode)),
      memory_(budget_bytes),
      chunks_(budget_bytes, Held::kStays) {}

void ZarrChunkCache::setBudget(uint64_t budget_bytes) {
  memory_.setLimit(budget_bytes);
  chunks_.setBudget(budget_bytes);
}

ZarrChunkCache::Chunk ZarrChunkCache::get(int64_t chunk) {
  // A decoder holds its input too.
  return chunks_.get(chunk, 2 * chunk_bytes_, [&] {
    return Chunks::Loaded{decode_(chunk, memory_), chunk_bytes_};
  });
}

}  // namespace sluice
