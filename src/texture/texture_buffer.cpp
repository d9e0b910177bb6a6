#include "src/texture/texture_buffer.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/texture/fill_chunk.h"
#include "src/texture/read_runs.h"

namespace sluice {

// `name` and `texels` are constant after construction (the bytes are the workers' until it is
// filled); the rest is guarded by the buffer's mutex.
struct TextureBuffer::Entry {
  uint64_t name = 0;
  std::shared_ptr<ChunkTexels> texels;
  size_t fillings_left = 0;
  int64_t pins = 0;  // batches that want it
  enum class State { kFilling, kFilled, kFailed } state = State::kFilling;
  std::exception_ptr failure;           // of the first filling that failed or was skipped
  std::list<EntryPtr>::iterator place;  // in recent_ while filled
};

// A texture block on its way into a chunk.
struct TextureBuffer::Filling {
  TextureBlock block;
  Vec3i room;  // the texels from block.at on that it fills
  EntryPtr into;
};

// Constant from begin() to finish(), but for `next`.
class TextureBuffer::Batch {
 public:
  int64_t time = 0;
  std::vector<EntryPtr> wanted;  // in the order asked for; empty when finished or cancelled
  std::vector<Filling> fillings;
  std::vector<ReadRun> runs;    // of the fillings' blocks
  size_t runs_at_once = 1;      // of all batches
  std::atomic<size_t> next{0};  // the run that no one has taken yet
};

namespace {

struct Cancelled : std::exception {
  const char* what() const noexcept override { return "no longer wanted"; }
};

}  // namespace

TextureBuffer::TextureBuffer(VolumeBuffer& blocks, WorkerPool& pool, uint64_t budget_bytes)
    : blocks_(blocks), pool_(pool), memory_(BufferMemory::make(budget_bytes)) {
  counters_.budget_bytes = budget_bytes;
}

TextureBuffer::~TextureBuffer() {
  waitUntilIdle();
}

void TextureBuffer::waitUntilIdle() {
  std::unique_lock lock(mutex_);
  settled_.wait(lock, [&] { return workers_under_way_ == 0; });
}

uint64_t TextureBuffer::bytesOf(const TexturePlan& plan, const Chunk& chunk) {
  return static_cast<uint64_t>(chunk.pages * plan.page.pageBytes());
}

CacheCounters TextureBuffer::counters() const {
  std::lock_guard lock(mutex_);
  return counters_;
}

void TextureBuffer::resetCounters() {
  std::lock_guard lock(mutex_);
  counters_.reset();
}

bool TextureBuffer::makeRoom(uint64_t bytes) {
  auto victim = recent_.end();
  while (counters_.current_bytes + reserved_bytes_ + bytes > counters_.budget_bytes) {
    do {
      if (victim == recent_.begin()) return false;
      --victim;
    } while ((*victim)->pins > 0 || (*victim)->texels.use_count() > 1);
    counters_.countEviction((*victim)->texels->byte_count);
    entries_.erase((*victim)->name);
    victim = recent_.erase(victim);
  }
  return true;
}

TextureBuffer::EntryPtr TextureBuffer::publish(const TexturePlan& plan, const Chunk& chunk,
                                               uint64_t name) {
  auto entry = std::make_shared<Entry>();
  entry->name = name;
  entry->texels = std::make_shared<ChunkTexels>();
  entry->texels->storage_vox = plan.page.pageGridOf(chunk.size_vox) * plan.page.size_vox;
  entry->texels->byte_count = bytesOf(plan, chunk);
  entry->fillings_left = chunk.blocks.size();
  reserved_bytes_ += entry->texels->byte_count;
  entry->texels->bytes = memory_->take(entry->texels->byte_count);  // the workers write it all
  entries_[name] = entry;
  return entry;
}

TextureBuffer::BatchPtr TextureBuffer::tryBegin(const TexturePlan& plan,
                                                std::span<const uint64_t> names,
                                                std::span<const int64_t> chunks,
                                                std::span<const int64_t> soon) {
  auto batch = std::make_shared<Batch>();
  batch->time = plan.time;
  std::vector<Filling> fillings;
  std::vector<int64_t> soon_blocks;
  {
    std::lock_guard lock(mutex_);
    // What is held already is pinned first, so that making room does not take it.
    std::unordered_set<uint64_t> fresh;
    uint64_t fresh_bytes = 0;
    for (const int64_t position : chunks) {
      const uint64_t name = names[static_cast<size_t>(position)];
      const auto found = entries_.find(name);
      if (found != entries_.end()) {
        batch->wanted.push_back(found->second);
        ++found->second->pins;
      } else if (fresh.insert(name).second) {
        fresh_bytes += bytesOf(plan, plan.chunks[static_cast<size_t>(position)]);
      }
    }
    const bool has_room = makeRoom(fresh_bytes);
    unpin(*batch);
    if (!has_room) return nullptr;
    for (const int64_t position : chunks) {
      const Chunk& chunk = plan.chunks[static_cast<size_t>(position)];
      const uint64_t name = names[static_cast<size_t>(position)];
      const auto found = entries_.find(name);
      EntryPtr entry = found == entries_.end() ? nullptr : found->second;
      if (entry == nullptr) {
        counters_.countMiss();
        entry = publish(plan, chunk, name);
        const std::vector<Vec3i> rooms = roomsOf(plan, chunk, entry->texels->storage_vox);
        for (size_t i = 0; i < rooms.size(); ++i)
          fillings.push_back({plan.blocks[static_cast<size_t>(chunk.blocks[i])], rooms[i], entry});
      } else if (entry->state == Entry::State::kFilled) {
        counters_.countHit();
        recent_.splice(recent_.begin(), recent_, entry->place);
      } else {
        counters_.countMiss();
        counters_.countCoalesced();
      }
      ++entry->pins;
      batch->wanted.push_back(std::move(entry));
    }
    if (!fillings.empty()) soon_blocks = blocksSoon(plan, names, soon);
  }
  planRuns(*batch, std::move(fillings), std::move(soon_blocks), plan.layout.grid.x);
  const auto helpers = std::min<int64_t>(pool_.threads(), static_cast<int64_t>(batch->runs.size()));
  {
    std::lock_guard lock(mutex_);
    workers_under_way_ += helpers;
  }
  for (int64_t i = 0; i < helpers; ++i)
    pool_.submit([this, batch] {
      work(*batch);
      std::lock_guard lock(mutex_);
      --workers_under_way_;
      settled_.notify_all();
    });
  return batch;
}

TextureBuffer::BatchPtr TextureBuffer::begin(const TexturePlan& plan,
                                             std::span<const uint64_t> names,
                                             std::span<const int64_t> chunks,
                                             std::span<const int64_t> soon) {
  for (;;) {
    std::unique_lock lock(mutex_);
    const uint64_t filling_bytes = reserved_bytes_;
    lock.unlock();
    BatchPtr batch = tryBegin(plan, names, chunks, soon);
    if (batch != nullptr) return batch;
    if (filling_bytes == 0) break;
    lock.lock();
    settled_.wait(lock, [&] { return reserved_bytes_ < filling_bytes; });
  }
  uint64_t bytes = 0;
  std::lock_guard lock(mutex_);
  for (const int64_t position : chunks) {
    if (entries_.contains(names[static_cast<size_t>(position)])) {
      counters_.countHit();
      continue;
    }
    counters_.countMiss();
    counters_.countFailure();
    bytes += bytesOf(plan, plan.chunks[static_cast<size_t>(position)]);
  }
  fail(
      "the texture buffer of {} cannot hold {} more beside the {} in use; give more --memory, a "
      "smaller --block or fewer --pages",
      formatBytes(counters_.budget_bytes), formatBytes(bytes),
      formatBytes(counters_.current_bytes + reserved_bytes_));
}

std::vector<int64_t> TextureBuffer::blocksSoon(const TexturePlan& plan,
                                               std::span<const uint64_t> names,
                                               std::span<const int64_t> soon) const {
  std::vector<int64_t> blocks;
  // More would be gone before their turn.
  const uint64_t most = blocks_.counters().budget_bytes * 3 / 4 / blocks_.blockBytes();
  for (const int64_t position : soon) {
    if (blocks.size() >= most) break;
    if (entries_.contains(names[static_cast<size_t>(position)])) continue;
    for (const int64_t block : plan.chunks[static_cast<size_t>(position)].blocks)
      blocks.push_back(plan.blocks[static_cast<size_t>(block)].block);
  }
  return blocks;
}

void TextureBuffer::planRuns(Batch& batch, std::vector<Filling> fillings, std::vector<int64_t> soon,
                             int64_t blocks_a_row) const {
  const auto blockOf = [](const Filling& filling) { return filling.block.block; };
  std::ranges::sort(fillings, {}, blockOf);
  std::ranges::sort(soon);
  std::vector<int64_t> wanted;
  std::ranges::transform(fillings, std::back_inserter(wanted), blockOf);
  // The caller reads too.
  const RunLimits limits = runLimits(blocks_.counters().budget_bytes / blocks_.blockBytes(),
                                     blocks_a_row, static_cast<size_t>(pool_.threads()) + 1);
  batch.runs = readRuns(wanted, soon, blocks_a_row, limits.blocks);
  batch.runs_at_once = limits.runs;
  batch.fillings = std::move(fillings);
}

void TextureBuffer::work(Batch& batch) {
  for (;;) {
    std::unique_lock lock(mutex_);
    settled_.wait(lock, [&] {
      return runs_under_way_ < batch.runs_at_once || batch.next >= batch.runs.size();
    });
    const size_t i = batch.next.fetch_add(1);
    if (i >= batch.runs.size()) return;
    ++runs_under_way_;
    lock.unlock();
    const ReadRun& run = batch.runs[i];
    std::exception_ptr failure;
    try {
      fill(batch, run);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    --runs_under_way_;
    for (size_t at = run.from; at < run.to; ++at) {
      const auto& [block, room, into] = batch.fillings[at];
      if (failure && !into->failure) into->failure = failure;
      if (!failure)
        counters_.decoded_bytes +=
            static_cast<uint64_t>(block.voxels.count()) *
            (into->texels->byte_count / static_cast<uint64_t>(volume(into->texels->storage_vox)));
      settle(into, 1);
    }
    // One that failed fails the batch: the rest would be read for nothing.
    if (failure) skipRest(batch, failure);
    settled_.notify_all();
  }
}

void TextureBuffer::fill(Batch& batch, const ReadRun& run) {
  throwIfInterrupted();
  std::vector<BlockKey> keys;
  std::vector<bool> ahead;
  const std::span wanted(batch.fillings.data() + run.from, run.to - run.from);
  for (const int64_t block : run.blocks) {
    keys.push_back({batch.time, block});
    ahead.push_back(!std::ranges::binary_search(
        wanted, block, {}, [](const Filling& filling) { return filling.block.block; }));
  }
  const std::vector<VolumeBlockPtr> blocks = blocks_.acquire(keys, ahead);
  const Stopwatch watch;
  for (const Filling& filling : wanted) {
    const auto found = std::lower_bound(run.blocks.begin(), run.blocks.end(), filling.block.block);
    copyTextureBlock(filling.block, *blocks[static_cast<size_t>(found - run.blocks.begin())],
                     filling.into->texels->storage_vox, filling.room, filling.into->texels->span());
  }
  copy_ns_ += static_cast<int64_t>(watch.seconds() * 1e9);
}

void TextureBuffer::settle(const EntryPtr& entry, size_t fillings) {
  entry->fillings_left -= fillings;
  if (entry->fillings_left > 0) return;
  const uint64_t bytes = entry->texels->byte_count;
  reserved_bytes_ -= bytes;
  const auto found = entries_.find(entry->name);
  const bool ours = found != entries_.end() && found->second == entry;
  if (entry->failure) {
    entry->state = Entry::State::kFailed;
    if (ours) entries_.erase(found);
    counters_.countFailure();
    return;
  }
  entry->state = Entry::State::kFilled;
  recent_.push_front(entry);
  entry->place = recent_.begin();
  counters_.countLoad(bytes, !seen_.insert(entry->name).second);
}

void TextureBuffer::unpin(Batch& batch) {
  for (const EntryPtr& entry : batch.wanted) --entry->pins;
  batch.wanted.clear();
}

void TextureBuffer::skipRest(Batch& batch, const std::exception_ptr& why) {
  for (size_t i = batch.next.exchange(batch.runs.size()); i < batch.runs.size(); ++i)
    for (size_t at = batch.runs[i].from; at < batch.runs[i].to; ++at) {
      const EntryPtr& entry = batch.fillings[at].into;
      if (!entry->failure) entry->failure = why;
      // No one finds it any more: a later request fills it anew.
      const auto found = entries_.find(entry->name);
      if (found != entries_.end() && found->second == entry) entries_.erase(found);
      settle(entry, 1);
    }
}

std::vector<ChunkTexelsPtr> TextureBuffer::finish(const BatchPtr& batch) {
  work(*batch);
  std::vector<ChunkTexelsPtr> texels;
  std::exception_ptr failure;
  std::unique_lock lock(mutex_);
  for (const EntryPtr& entry : batch->wanted) {
    settled_.wait(lock, [&] { return entry->state != Entry::State::kFilling; });
    if (!failure) failure = entry->failure;
    texels.push_back(entry->texels);
  }
  unpin(*batch);
  batch->fillings.clear();  // all settled: a worker that comes late finds no run to take
  lock.unlock();
  if (failure) std::rethrow_exception(failure);
  return texels;
}

std::vector<ChunkTexelsPtr> TextureBuffer::waitUntil(
    const BatchPtr& batch, std::chrono::steady_clock::time_point deadline) {
  std::vector<ChunkTexelsPtr> texels;
  std::unique_lock lock(mutex_);
  for (const EntryPtr& entry : batch->wanted) {
    settled_.wait_until(lock, deadline, [&] { return entry->state != Entry::State::kFilling; });
    if (entry->failure) std::rethrow_exception(entry->failure);
    texels.push_back(entry->state == Entry::State::kFilled ? entry->texels : nullptr);
  }
  return texels;
}

void TextureBuffer::cancel(const BatchPtr& batch) {
  std::lock_guard lock(mutex_);
  const std::vector<EntryPtr> entries = batch->wanted;
  unpin(*batch);
  // Another batch may wait for what this one fills: then it goes on.
  const bool is_wanted =
      std::ranges::any_of(entries, [](const EntryPtr& entry) { return entry->pins > 0; });
  if (!is_wanted) skipRest(*batch, std::make_exception_ptr(Cancelled()));
}

std::vector<ChunkTexelsPtr> TextureBuffer::acquire(const TexturePlan& plan,
                                                   std::span<const uint64_t> names,
                                                   std::span<const int64_t> chunks) {
  return finish(begin(plan, names, chunks));
}

}  // namespace sluice
