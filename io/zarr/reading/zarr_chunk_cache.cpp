#include "io/zarr/reading/zarr_chunk_cache.h"

#include <algorithm>
#include <utility>

namespace sluice {
namespace {

// A chunk counts as at least this much, which is more than the cache needs to keep a small one.
constexpr uint64_t kLeastBytes = 512;
// The most buffers that are kept for the next chunks; take() looks through them.
constexpr size_t kMostKept = 256;

}  // namespace

ChunkMemory::Buffer ChunkMemory::take(uint64_t bytes) {
  const MutexLock lock(mutex_);
  auto best = kept_.end();
  for (auto buffer = kept_.begin(); buffer != kept_.end(); ++buffer)
    // Buffers are at most twice as large, so that small chunks do not hold large ones.
    if (buffer->size >= bytes && buffer->size / 2 <= bytes &&
        (best == kept_.end() || buffer->size < best->size))
      best = buffer;
  if (best != kept_.end()) {
    Buffer found = std::move(*best);
    kept_.erase(best);
    return found;
  }
  // None is of that size: one of them makes way.
  if (!kept_.empty()) {
    now_ -= kept_.back().size;
    kept_.pop_back();
  }
  Buffer made{alignedForOverwrite<std::byte>(static_cast<size_t>(bytes)), bytes};
  now_ += bytes;
  peak_ = std::max(peak_.load(), now_.load());
  return made;
}

void ChunkMemory::give(Buffer buffer) {
  const MutexLock lock(mutex_);
  // Kept, since a fresh buffer costs a page fault for every 4 KiB.
  if (now_ <= limit_bytes_ && kept_.size() < kMostKept)
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

ZarrChunkCache::ZarrChunkCache(uint64_t budget_bytes)
    : memory_(budget_bytes), chunks_(budget_bytes, Held::kStays) {}

int ZarrChunkCache::addArray(uint64_t chunk_bytes, Decode decode) {
  arrays_.push_back({std::max(chunk_bytes, kLeastBytes), std::move(decode)});
  return static_cast<int>(arrays_.size()) - 1;
}

void ZarrChunkCache::setBudget(uint64_t budget_bytes) {
  memory_.setLimit(budget_bytes);
  chunks_.setBudget(budget_bytes);
}

ZarrChunkCache::Chunk ZarrChunkCache::get(const Key& key, IfLoading if_loading) {
  const Array& array = arrays_[static_cast<size_t>(key.array)];
  const auto load = [&] {
    return Chunks::Loaded{array.decode(key.chunk, memory_), array.counted_bytes};
  };
  return chunks_.get(key, 2 * array.counted_bytes, load, if_loading);  // a decoder holds its input
}

}  // namespace sluice
