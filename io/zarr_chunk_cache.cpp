#include "io/zarr_chunk_cache.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sluice {

ChunkMemory::Buffer ChunkMemory::take(uint64_t bytes) {
  const std::lock_guard lock(mutex_);
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
  const std::lock_guard lock(mutex_);
  if (now_ <= limit_bytes_)
    kept_.push_back(std::move(buffer));
  else
    now_ -= buffer.size;
}

void ChunkMemory::setLimit(uint64_t limit_bytes) {
  const std::lock_guard lock(mutex_);
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
      budget_bytes_(budget_bytes) {}

void ZarrChunkCache::setBudget(uint64_t budget_bytes) {
  const std::lock_guard lock(mutex_);
  budget_bytes_ = budget_bytes;
  memory_.setLimit(budget_bytes);
  makeRoom();
}

ZarrChunkCache::Chunk ZarrChunkCache::get(int64_t chunk) {
  std::unique_lock lock(mutex_);
  if (const auto found = entries_.find(chunk); found != entries_.end()) {
    const std::shared_ptr<Entry> entry = found->second;
    decoded_.wait(lock, [&] { return entry->chunk || entry->failure; });
    if (entry->failure) std::rethrow_exception(entry->failure);
    // Gone from the list where it was dropped while this thread woke up.
    if (const auto again = entries_.find(chunk); again != entries_.end() && again->second == entry)
      used_.splice(used_.begin(), used_, entry->at);
    return entry->chunk;
  }
  const auto entry = std::make_shared<Entry>();
  entries_[chunk] = entry;
  ++decoding_;
  makeRoom();
  lock.unlock();
  Chunk decoded;
  std::exception_ptr failure;
  try {
    decoded = decode_(chunk, memory_);
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  --decoding_;
  entry->chunk = decoded;
  entry->failure = failure;
  if (failure) {
    entries_.erase(chunk);
  } else {
    used_.push_front(chunk);
    entry->at = used_.begin();
    makeRoom();
  }
  lock.unlock();
  decoded_.notify_all();
  if (failure) std::rethrow_exception(failure);
  return decoded;
}

// Drops the chunks used longest ago, but none that somebody holds.
void ZarrChunkCache::makeRoom() {
  auto next = used_.end();
  while (next != used_.begin() && (used_.size() + 2 * decoding_) * chunk_bytes_ > budget_bytes_) {
    --next;
    const auto entry = entries_.find(*next);
    // One owner: the entry itself. Nobody else can come to be one without the mutex.
    if (entry->second->chunk.use_count() > 1) continue;
    entries_.erase(entry);
    next = used_.erase(next);
  }
}

}  // namespace sluice
