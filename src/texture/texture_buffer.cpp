#include "src/texture/texture_buffer.h"

#include <algorithm>
#include <new>
#include <unordered_set>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/texture/fill_chunk.h"
#include "src/texture/read_runs.h"

namespace sluice {

// A texture block on its way into a chunk.
struct TextureBuffer::Filling {
  TextureBlock block;
  Vec3i room;  // the texels from block.at on that it fills
  EntryPtr into;
  VoxelPlanes planes;  // of the block's level
};

// Constant from begin() to finish(), but for `next`.
class TextureBuffer::Batch {
 public:
  ReadPurpose purpose;
  std::vector<EntryPtr> wanted;  // in the order asked for; empty when finished or cancelled
  std::vector<EntryPtr> ours;    // the entries of `wanted` that this batch fills
  std::vector<Filling> fillings;
  std::vector<ReadRun> runs;    // over the fillings' blocks
  size_t runs_at_once = 1;      // over all batches
  std::atomic<size_t> next{0};  // the run that no one has taken yet
};

namespace {

struct Dropped : std::exception {
  const char* what() const noexcept override { return "no longer wanted"; }
};

}  // namespace

TextureBuffer::TextureBuffer(VolumeBuffer& blocks, WorkerPool& pool, uint64_t budget_bytes)
    : blocks_(blocks),
      pool_(pool),
      memory_(BufferMemory::make(budget_bytes)),
      chunks_(budget_bytes, Held::kStays) {}

TextureBuffer::~TextureBuffer() {
  waitUntilIdle();
}

void TextureBuffer::waitUntilIdle() {
  MutexLock lock(chunks_.mutex);
  while (workers_under_way_ > 0) chunks_.changed.wait(lock);
}

uint64_t TextureBuffer::bytesOf(const TexturePlan& plan, const Chunk& chunk) {
  return static_cast<uint64_t>(chunk.pages * plan.page.pageBytes());
}

TextureBuffer::EntryPtr TextureBuffer::publish(const TexturePlan& plan, const Chunk& chunk,
                                               ChunkName name, std::vector<Filling>& fillings) {
  auto texels = std::make_shared<ChunkTexels>();
  texels->size_vox = chunk.size_vox;
  texels->storage_vox = plan.page.pageGridOf(chunk.size_vox) * plan.page.size_vox;
  texels->type = blocks_.type();
  texels->has_spread = plan.numbersOf(chunk) == 2;
  texels->byte_count = bytesOf(plan, chunk);
  texels->bytes = memory_->take(texels->byte_count);  // the workers write it all
  // All memory for the fillings comes before publish(): a published entry must be filled or failed.
  const std::vector<Vec3i> rooms = roomsOf(plan, chunk, texels->storage_vox);
  fillings.reserve(fillings.size() + rooms.size());
  EntryPtr entry = chunks_.publish(name, texels->byte_count);
  entry->note = {texels, chunk.blocks.size()};
  for (size_t i = 0; i < rooms.size(); ++i)
    fillings.push_back(
        {plan.blocks[chunk.blocks[i]], rooms[i], entry,
         planesOn(plan.pyramid.of(plan.blocks[chunk.blocks[i]].name).placement, plan.planes)});
  return entry;
}

bool TextureBuffer::makeRoomFor(const TexturePlan& plan, const ChunkNameList& names,
                                std::span<const ChunkPosition> chunks) {
  // Entries already held are wanted meanwhile, so that making room does not evict them.
  std::vector<EntryPtr> held;
  held.reserve(chunks.size());
  std::unordered_set<ChunkName> fresh;
  uint64_t fresh_bytes = 0;
  for (const ChunkPosition position : chunks) {
    const ChunkName name = names[position];
    if (const EntryPtr entry = chunks_.find(name))
      held.push_back(entry);
    else if (fresh.insert(name).second)
      fresh_bytes += bytesOf(plan, plan.chunks[position]);
  }
  for (const EntryPtr& entry : held) ++entry->wanted_by;
  const bool has_room = chunks_.makeRoom(fresh_bytes);
  for (const EntryPtr& entry : held) chunks_.letGo(entry);
  return has_room;
}

TextureBuffer::BatchPtr TextureBuffer::tryBegin(const TexturePlan& plan, const ChunkNameList& names,
                                                std::span<const ChunkPosition> chunks,
                                                std::span<const ChunkPosition> soon,
                                                const ReadPurpose& purpose) {
  auto batch = std::make_shared<Batch>();
  batch->purpose = purpose;
  batch->wanted.reserve(chunks.size());
  batch->ours.reserve(chunks.size());
  MutexLock lock(chunks_.mutex);
  if (!makeRoomFor(plan, names, chunks)) return nullptr;
  try {
    std::vector<Filling> fillings;
    for (const ChunkPosition position : chunks) {
      const ChunkName name = names[position];
      EntryPtr entry = chunks_.join(name);
      if (entry == nullptr) {
        entry = publish(plan, plan.chunks[position], name, fillings);
        batch->ours.push_back(entry);
      }
      batch->wanted.push_back(std::move(entry));
    }
    std::vector<BlockName> soon_blocks;
    // Only a batch that reads anything takes the blocks of `soon` along.
    if (!fillings.empty()) soon_blocks = blocksSoon(plan, names, soon);
    planRuns(*batch, std::move(fillings), std::move(soon_blocks));
  } catch (...) {  // no memory: published entries would never be filled
    abandon(*batch);
    throw;
  }
  lock.unlock();
  // Workers are started without the lock, which each of them takes first.
  startHelpers(batch);
  return batch;
}

template <class Job>
bool TextureBuffer::startWorker(Job job) {
  {
    // Counted before it is submitted, so that waitUntilIdle() also waits for a worker still in the
    // pool's queue.
    const MutexLock lock(chunks_.mutex);
    ++workers_under_way_;
  }
  try {
    pool_.submit([this, job = std::move(job)] {
      job();
      helperIsDone();
    });
    return true;
  } catch (const std::bad_alloc&) {
    helperIsDone();
    return false;
  }
}

void TextureBuffer::startHelpers(const BatchPtr& batch) {
  const auto helpers = std::min<int64_t>(pool_.threads(), static_cast<int64_t>(batch->runs.size()));
  for (int64_t i = 0; i < helpers; ++i)
    if (!startWorker([this, batch] { work(*batch); })) return;  // finish() does without
}

void TextureBuffer::makeReady(uint64_t bytes) {
  if (bytes == 0) return;
  // Without memory for the job the next frame waits for the system.
  startWorker([this, bytes] { memory_->makeReady(std::min(bytes, kMostReadyBytes)); });
}

void TextureBuffer::helperIsDone() {
  const MutexLock lock(chunks_.mutex);
  --workers_under_way_;
  chunks_.changed.notifyAll();
}

TextureBuffer::BatchPtr TextureBuffer::begin(const TexturePlan& plan, const ChunkNameList& names,
                                             std::span<const ChunkPosition> chunks,
                                             std::span<const ChunkPosition> soon,
                                             const ReadPurpose& purpose) {
  for (;;) {
    MutexLock lock(chunks_.mutex);
    // Asked before the attempt: if a filling ends in between, its room is free and the attempt is
    // repeated at once.
    const uint64_t filling_bytes = chunks_.loadingBytes();
    lock.unlock();
    BatchPtr batch = tryBegin(plan, names, chunks, soon, purpose);
    if (batch != nullptr) return batch;
    // Nothing is being filled that could give room when it ends: the rest is pinned.
    if (filling_bytes == 0) break;
    lock.lock();
    while (chunks_.loadingBytes() >= filling_bytes) chunks_.changed.wait(lock);
  }
  uint64_t bytes = 0;
  // The requests that fail are counted, too, so that requests = hits + misses holds.
  const MutexLock lock(chunks_.mutex);
  for (const ChunkPosition position : chunks) {
    if (chunks_.find(names[position]) != nullptr) {
      chunks_.countHit();
      continue;
    }
    chunks_.countNoRoom();
    bytes += bytesOf(plan, plan.chunks[position]);
  }
  failMemory(
      "the texture buffer of {} cannot hold {} more in addition to the {} in use; give more "
      "--memory, a smaller --block or fewer --pages",
      formatBytes(chunks_.budgetBytes()), formatBytes(bytes), formatBytes(chunks_.takenBytes()));
}

std::vector<BlockName> TextureBuffer::blocksSoon(const TexturePlan& plan,
                                                 const ChunkNameList& names,
                                                 std::span<const ChunkPosition> soon) const {
  std::vector<BlockName> blocks;
  // More blocks would be evicted before their turn.
  const uint64_t most = blocks_.counters().budget_bytes * 3 / 4 / blocks_.blockBytes();
  for (const ChunkPosition position : soon) {
    if (blocks.size() >= most) break;
    if (chunks_.find(names[position]) != nullptr) continue;
    for (const BlockPosition block : plan.chunks[position].blocks)
      blocks.push_back(plan.blocks[block].name);
  }
  return blocks;
}

void TextureBuffer::planRuns(Batch& batch, std::vector<Filling> fillings,
                             std::vector<BlockName> soon) const {
  // The order is by name, so that the blocks of one row follow each other.
  std::ranges::sort(fillings, {}, [](const Filling& filling) { return filling.block.name; });
  std::ranges::sort(soon);
  // The caller reads too.
  const size_t threads = static_cast<size_t>(pool_.threads()) + 1;
  const uint64_t level_blocks = blocks_.counters().budget_bytes / blocks_.blockBytes();
  batch.runs_at_once = threads;
  for (size_t from = 0; from < fillings.size();) {  // one grid of blocks after the other
    const BlockName first = fillings[from].block.name;
    const int64_t blocks_a_row = blocks_.rowBlocks(first.level);
    const RunLimits limits = runLimits(level_blocks, blocks_a_row, threads);
    batch.runs_at_once = std::min(batch.runs_at_once, limits.runs);
    std::vector<int64_t> wanted, beside;
    for (size_t i = from; i < fillings.size() && fillings[i].block.name.isBeside(first); ++i)
      wanted.push_back(fillings[i].block.name.block);
    for (const BlockName& name : soon)
      if (name.isBeside(first)) beside.push_back(name.block);
    for (ReadRun& run : readRuns(wanted, beside, blocks_a_row, limits.blocks)) {
      run.from += from;
      run.to += from;
      batch.runs.push_back(std::move(run));
    }
    from += wanted.size();
  }
  batch.fillings = std::move(fillings);
}

void TextureBuffer::work(Batch& batch) {
  for (;;) {
    MutexLock lock(chunks_.mutex);
    // Runs of all batches count, since together they must leave room in level 2 for the blocks read
    // along.
    while (runs_under_way_ >= batch.runs_at_once && batch.next < batch.runs.size())
      chunks_.changed.wait(lock);
    // A number beyond the last run does no harm: nobody takes one behind it.
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
    // All of this run under one lock: as soon as its last filling is settled, finish() may clear
    // the list.
    for (size_t at = run.from; at < run.to; ++at) {
      const auto& [block, room, into, planes] = batch.fillings[at];
      const ChunkTexels& texels = *into->note.texels;
      if (failure && !into->note.failure) into->note.failure = failure;
      if (!failure) {
        const uint64_t bytes = static_cast<uint64_t>(block.voxels.count()) * texels.texelBytes();
        chunks_.countDecoded(bytes);
        if (batch.purpose.tally != nullptr) batch.purpose.tally->copied_bytes += bytes;
      }
      settle(into);
    }
    // A failed filling fails the batch, because reading the rest would be useless.
    if (failure) skipRest(batch, failure);
    chunks_.changed.notifyAll();
  }
}

void TextureBuffer::fill(Batch& batch, const ReadRun& run) {
  batch.purpose.stop.throwIfStopped();
  ReadTally* const tally = batch.purpose.tally.get();
  std::vector<BlockName> names;
  std::vector<bool> ahead;
  const std::span wanted(batch.fillings.data() + run.from, run.to - run.from);
  for (const int64_t block : run.blocks) {
    names.push_back(wanted.front().block.name.withBlock(block));
    // Blocks that only lie next to wanted ones do not count as used in level 2.
    ahead.push_back(!std::ranges::binary_search(
        wanted, block, {}, [](const Filling& filling) { return filling.block.name.block; }));
  }
  const std::vector<VolumeBlockPtr> blocks = blocks_.acquire(names, ahead, tally);
  const Stopwatch watch;
  for (const Filling& filling : wanted) {
    const auto found =
        std::lower_bound(run.blocks.begin(), run.blocks.end(), filling.block.name.block);
    copyTextureBlock(filling.block, *blocks[static_cast<size_t>(found - run.blocks.begin())],
                     filling.into->note.texels->storage_vox, filling.room,
                     filling.into->note.texels->span(), filling.planes);
  }
  if (tally != nullptr) tally->copy_ns += static_cast<int64_t>(watch.seconds() * 1e9);
}

void TextureBuffer::settle(const EntryPtr& entry) {
  // Other blocks of the chunk are still to come. Each of them settles it once, also if it fails.
  if (--entry->note.fillings_left > 0) return;
  // The cache's value is then the only handle of ours.
  const std::shared_ptr<ChunkTexels> texels = std::move(entry->note.texels);
  if (entry->note.failure)
    chunks_.fail(entry, entry->note.failure);
  else
    chunks_.finish(entry, texels, texels->byte_count);
}

void TextureBuffer::abandon(Batch& batch) {
  for (const EntryPtr& entry : batch.ours) chunks_.fail(entry, std::current_exception());
  for (const EntryPtr& entry : batch.wanted) Chunks::letGo(entry);
}

void TextureBuffer::skipRest(Batch& batch, const std::exception_ptr& why) {
  // Takes all runs that nobody has begun, so that no worker finds one later.
  for (size_t i = batch.next.exchange(batch.runs.size()); i < batch.runs.size(); ++i)
    for (size_t at = batch.runs[i].from; at < batch.runs[i].to; ++at) {
      const EntryPtr& entry = batch.fillings[at].into;
      if (!entry->note.failure) entry->note.failure = why;
      chunks_.hide(entry);  // a later request fills it anew
      settle(entry);
    }
}

std::vector<ChunkTexelsPtr> TextureBuffer::finish(const BatchPtr& batch) {
  // This thread fills, too: without helpers it fills all.
  work(*batch);
  std::vector<ChunkTexelsPtr> texels;
  std::exception_ptr failure;
  MutexLock lock(chunks_.mutex);
  for (const EntryPtr& entry : batch->wanted) {
    try {
      // All entries are taken even after a failure, since each of them is wanted once.
      texels.push_back(chunks_.take(lock, entry));
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  }
  batch->wanted.clear();
  batch->ours.clear();
  batch->fillings.clear();  // all settled: a worker that comes late finds no run to take
  lock.unlock();
  if (failure) std::rethrow_exception(failure);
  return texels;
}

std::vector<ChunkTexelsPtr> TextureBuffer::waitUntil(
    const BatchPtr& batch, std::chrono::steady_clock::time_point deadline) {
  std::vector<ChunkTexelsPtr> texels;
  MutexLock lock(chunks_.mutex);
  for (const EntryPtr& entry : batch->wanted) {
    // An entry that was late does not keep the others from being looked at, as the deadline has
    // passed for all.
    while (entry->state == Chunks::Entry::State::kLoading &&
           chunks_.changed.waitUntil(lock, deadline)) {
    }
    if (entry->failure) std::rethrow_exception(entry->failure);
    texels.push_back(entry->value);
  }
  return texels;
}

void TextureBuffer::cancel(const BatchPtr& batch) {
  const MutexLock lock(chunks_.mutex);
  const std::vector<EntryPtr> entries = std::exchange(batch->wanted, {});
  for (const EntryPtr& entry : entries) Chunks::letGo(entry);
  // Another batch may wait for a chunk that this one fills: then filling goes on.
  const bool is_wanted =
      std::ranges::any_of(entries, [](const EntryPtr& entry) { return entry->wanted_by > 0; });
  if (!is_wanted) skipRest(*batch, std::make_exception_ptr(Dropped()));
}

std::vector<ChunkTexelsPtr> TextureBuffer::acquire(const TexturePlan& plan,
                                                   const ChunkNameList& names,
                                                   std::span<const ChunkPosition> chunks) {
  return finish(begin(plan, names, chunks));
}

}  // namespace sluice
