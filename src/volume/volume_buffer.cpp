#include "src/volume/volume_buffer.h"

#include <algorithm>
#include <new>
#include <utility>

#include "src/base/error.h"
#include "src/base/sources/read_units.h"
#include "src/base/threads/clock.h"
#include "src/base/threads/stop_token.h"
#include "src/base/values/bytes.h"
#include "src/volume/block_side.h"

namespace sluice {
namespace {

// Voxels of a level and their spreads in device form, without the planes that blocks share.
uint64_t bytesOf(const VolumeBuffer::Level& level) {
  return static_cast<uint64_t>(volume(level.layout.dims)) *
         bytesPerVoxel(deviceMap(level.source->layout()).type) * (level.spreads == nullptr ? 1 : 2);
}

// VolumeBuffer::rowBlocks() of each level.
std::vector<int64_t> rowBlocksOf(const std::vector<VolumeBuffer::Level>& levels) {
  std::vector<int64_t> blocks;
  for (const VolumeBuffer::Level& level : levels) {
    const Vec3i grid = level.layout.grid;
    const bool is_wide = readUnits(*level.source).voxels.y > level.layout.size;
    blocks.push_back(is_wide ? grid.x * grid.y : grid.x);
  }
  return blocks;
}

}  // namespace

VolumeBuffer::VolumeBuffer(VolumeSource& source, const BlockLayout& layout, uint64_t budget_bytes,
                           Cold cold)
    : VolumeBuffer({{&source, layout}}, budget_bytes, cold) {}

VolumeBuffer::VolumeBuffer(std::vector<Level> levels, uint64_t budget_bytes, Cold cold)
    : levels_(std::move(levels)),
      row_blocks_(rowBlocksOf(levels_)),
      map_(deviceMap(levels_.front().source->layout())),
      // Packing needs room for one more block beside the resident ones. In a budget of fewer than
      // 16 blocks, that block would take too much of it.
      packs_(cold == Cold::kPacked && budget_bytes >= 16 * blockBytes()),
      keeps_coarsest_(levels_.size() > 1 && bytesOf(levels_.back()) <= budget_bytes / 8),
      memory_(BufferMemory::make(budget_bytes)),
      blocks_(budget_bytes, Held::kStays) {
  for (const Level& level : levels_) {
    SLUICE_CHECK_EQ(level.layout.size, levels_.front().layout.size);
    const ValueMap map = deviceMap(level.source->layout());
    SLUICE_CHECK(map.type == map_.type && map.scale == map_.scale && map.offset == map_.offset);
    if (level.spreads == nullptr) continue;
    SLUICE_CHECK(level.spreads->layout().dims == level.source->layout().dims);
    SLUICE_CHECK(deviceMap(level.spreads->layout()).type == map_.type);
  }
}
VolumeBuffer::~VolumeBuffer() = default;

uint64_t VolumeBuffer::blockBytes() const {
  const int64_t side = blockSide(levels_.front().layout, static_cast<int64_t>(levels_.size()));
  const bool has_spreads =
      std::ranges::any_of(levels_, [](const Level& level) { return level.spreads != nullptr; });
  return static_cast<uint64_t>(volume(Vec3i{side, side, side})) * bytesPerVoxel(map_.type) *
         (has_spreads ? 2 : 1);
}

bool VolumeBuffer::hasRoom(uint64_t bytes) const {
  // The block that packing may produce is room that no other block gets.
  const uint64_t scratch = packs_ ? blockBytes() : 0;
  return blocks_.takenBytes() + scratch + bytes <= blocks_.budgetBytes();
}

void VolumeBuffer::countPacked(int64_t bytes) {
  packed_bytes_ += static_cast<uint64_t>(bytes);
  // The memory keeps freed pieces for reuse, and packed blocks lie elsewhere: together they must
  // stay within the budget.
  const uint64_t scratch = packs_ ? blockBytes() : 0;
  memory_->setLimit(blocks_.budgetBytes() - scratch - packed_bytes_);
}

void VolumeBuffer::freeSome(MutexLock& lock, const BlockName& key, uint64_t bytes) {
  // The coarsest blocks of the step in use go last, since any picture can fall back on them.
  const EntryPtr victim =
      blocks_.coldest([&](const BlockName& name) { return !staysLongest(name, key.time); });
  // Packed blocks go if nothing else may, or if they fill more than their half of the budget.
  if ((victim == nullptr || cold_bytes_ > blocks_.budgetBytes() / 2) && !cold_.empty()) {
    dropColdest();
  } else if (victim != nullptr) {
    packOrDrop(lock, victim, key);
  } else if (packing_) {
    // The room comes when the other thread has packed its block.
    while (packing_) blocks_.changed.wait(lock);
  } else if (const EntryPtr last = blocks_.coldest()) {
    packOrDrop(lock, last, key);
  } else {
    failMemory(
        "the volume buffer of {} cannot hold {} more in addition to the {} in use; give more "
        "--memory or a smaller --block",
        formatBytes(blocks_.budgetBytes()), formatBytes(bytes), formatBytes(blocks_.takenBytes()));
  }
}

void VolumeBuffer::dropColdest() {
  const Packed& packed = cold_.back();
  cold_bytes_ -= packed.bytes.byte_count;
  blocks_.countPackedEviction(packed.bytes.byte_count);
  countPacked(-static_cast<int64_t>(packed.bytes.byte_count));
  cold_by_key_.erase(packed.key);
  cold_.pop_back();
}

void VolumeBuffer::packOrDrop(MutexLock& lock, const EntryPtr& victim, const BlockName& for_block) {
  // Packing pays for blocks that are asked for again: those that were before, and finer ones that
  // make room for a coarse picture.
  const bool is_worth_it = victim->note.reused || victim->key.level < for_block.level;
  if (!packs_ || !is_worth_it) {
    blocks_.evict(victim);
    return;
  }
  // One thread packs at a time, so that scratch for one block is enough. Its result makes room,
  // too.
  if (packing_) {
    while (packing_) blocks_.changed.wait(lock);
    return;
  }
  packing_ = true;
  ++victim->wanted_by;  // so that it stays meanwhile
  const VolumeBlock& block = *victim->value;
  blocks_.mutex.unlock();  // the mutex that `lock` holds
  std::optional<PackedBytes> packed;
  try {
    packed = pack({block.bytes.get(), block.byteCount()}, bytesPerVoxel(block.type));
  } catch (...) {  // no memory: then it is dropped, which gives more than packing would
  }
  blocks_.mutex.lock();
  // The lock is held again: everything known about the cache before may have changed.
  packing_ = false;
  blocks_.letGo(victim);
  // Otherwise another thread wanted it in the meantime.
  if (blocks_.mayGo(*victim)) {
    if (packed)
      keepPacked(victim, std::move(*packed));
    else
      blocks_.evict(victim);
  }
  blocks_.changed.notifyAll();
}

void VolumeBuffer::keepPacked(const EntryPtr& entry, PackedBytes bytes) {
  const uint64_t byte_count = bytes.byte_count;
  try {
    cold_.push_front({entry->key, entry->note, std::move(bytes)});
    cold_by_key_.emplace(entry->key, cold_.begin());
  } catch (const std::bad_alloc&) {
    // push_front() may have succeeded before emplace() failed. The entry must not be in one of both
    // alone.
    if (!cold_.empty() && cold_.front().key == entry->key) cold_.pop_front();
    blocks_.evict(entry);
    return;
  }
  blocks_.pack(entry, byte_count);
  cold_bytes_ += byte_count;
  countPacked(static_cast<int64_t>(byte_count));
}

VolumeBuffer::EntryPtr VolumeBuffer::request(MutexLock& lock, const BlockName& key, bool ahead,
                                             std::vector<Own>& ours) {
  const Box3 voxels = storedVoxels(key);
  const uint64_t bytes =
      static_cast<uint64_t>(voxels.count() * numbersOf(key)) * bytesPerVoxel(map_.type);
  for (;;) {  // what is found may change while room is made
    if (EntryPtr entry = blocks_.join(key)) {
      entry->note.note(ahead);
      return entry;
    }
    if (!hasRoom(bytes)) {
      try {
        // freeSome() may give up the lock, so that the key is looked up anew.
        freeSome(lock, key, bytes);
      } catch (const Error&) {
        blocks_.countNoRoom();
        throw;
      }
      continue;
    }
    const auto packed = cold_by_key_.find(key);
    if (packed == cold_by_key_.end()) {
      ours.push_back({blocks_.publish(key, bytes), {}});
      ours.back().entry->note.note(ahead);
      return ours.back().entry;
    }
    // publish() may throw, and nothing has changed then: the bytes are moved after it.
    const std::list<Packed>::iterator from = packed->second;
    ours.push_back({blocks_.publish(key, bytes, from->bytes.byte_count), std::move(from->bytes)});
    EntryPtr entry = ours.back().entry;
    entry->note = from->use;
    entry->note.note(ahead);
    cold_bytes_ -= ours.back().packed.byte_count;
    cold_.erase(from);
    cold_by_key_.erase(packed);
    return entry;
  }
}

std::vector<VolumeBlockPtr> VolumeBuffer::acquire(std::span<const BlockName> keys,
                                                  const std::vector<bool>& ahead,
                                                  ReadTally* tally) {
  // All memory of this call first: once entries are published they must come to an end.
  std::vector<EntryPtr> wanted;
  std::vector<Own> ours;
  std::vector<VolumeBlockPtr> blocks;
  wanted.reserve(keys.size());
  ours.reserve(keys.size());
  blocks.reserve(keys.size());
  std::exception_ptr failure;
  {
    MutexLock lock(blocks_.mutex);
    for (size_t i = 0; i < keys.size() && !failure; ++i) {
      try {
        wanted.push_back(request(lock, keys[i], !ahead.empty() && ahead[i], ours));
      } catch (...) {  // no room, or no memory
        failure = std::current_exception();
      }
    }
  }
  // Published entries must be brought to an end, even if there is no room for the rest.
  loadOwn(ours, tally);

  MutexLock lock(blocks_.mutex);
  for (const EntryPtr& entry : wanted) {
    if (failure) {
      blocks_.letGo(entry);
      continue;
    }
    try {
      blocks.push_back(blocks_.take(lock, entry));
    } catch (...) {
      failure = std::current_exception();
    }
  }
  lock.unlock();
  if (failure) std::rethrow_exception(failure);
  return blocks;
}

// Blocks that follow each other in a row are read together. Packed ones between them end the run.
void VolumeBuffer::loadOwn(std::span<Own> ours, ReadTally* tally) noexcept {
  const auto besideEachOther = [&](const BlockName& a, const BlockName& b) {
    return a.isBeside(b) && a.block / rowBlocks(a.level) == b.block / rowBlocks(a.level);
  };
  for (size_t from = 0; from < ours.size();) {
    if (ours[from].packed.bytes != nullptr) {
      unpackAndFinish(ours[from++], tally);
      continue;
    }
    size_t to = from + 1;
    while (to < ours.size() && ours[to].packed.bytes == nullptr &&
           besideEachOther(ours[from].entry->key, ours[to].entry->key))
      ++to;
    loadAndFinish(ours.subspan(from, to - from), tally);
    from = to;
  }
}

std::shared_ptr<VolumeBlock> VolumeBuffer::emptyBlock(const BlockName& key) const {
  auto block = std::make_shared<VolumeBlock>();
  block->voxels = storedVoxels(key);
  block->type = map_.type;
  block->numbers = numbersOf(key);
  block->bytes = memory_->take(block->byteCount());
  return block;
}

std::exception_ptr VolumeBuffer::failureOf(const BlockName& key) const noexcept {
  // Rethrows the exception that is being handled, to tell its type.
  try {
    throw;
  } catch (const Error&) {
    return std::current_exception();
  } catch (const Interrupted&) {
    return std::current_exception();
  } catch (const std::bad_alloc&) {
    return std::current_exception();
  } catch (const std::exception& error) {
    try {
      return std::make_exception_ptr(Error(fmt::format(
          "{}: block {}: {}", levelOf(key).source->layout().calledBy(), key.block, error.what())));
    } catch (...) {
      return std::current_exception();
    }
  } catch (...) {
    return std::current_exception();
  }
}

void VolumeBuffer::unpackAndFinish(Own& own, ReadTally* tally) noexcept {
  Stopwatch watch;
  std::shared_ptr<VolumeBlock> block;
  std::exception_ptr failure;
  try {
    block = emptyBlock(own.entry->key);
    unpack(own.packed, {block->bytes.get(), block->byteCount()});
  } catch (...) {  // no memory: the waiting threads must hear of it
    failure = std::current_exception();
  }
  if (tally != nullptr) tally->decode_ns += static_cast<int64_t>(watch.seconds() * 1e9);
  const MutexLock lock(blocks_.mutex);
  if (failure)
    blocks_.fail(own.entry, failure);
  else
    // The room of the packed form becomes free only now: until then both forms count.
    blocks_.finish(own.entry, std::move(block), own.entry->bytes);
  countPacked(-static_cast<int64_t>(own.packed.byte_count));
  own.packed = {};
}

void VolumeBuffer::loadAndFinish(std::span<const Own> run, ReadTally* tally) noexcept {
  std::vector<std::shared_ptr<VolumeBlock>> blocks;
  std::exception_ptr failure;
  try {
    blocks = load(run, tally);
  } catch (...) {
    // The failure of a run names its first block, since a source reports none.
    failure = failureOf(run.front().entry->key);
  }
  const MutexLock lock(blocks_.mutex);
  for (size_t i = 0; i < run.size(); ++i) {
    const EntryPtr& entry = run[i].entry;
    if (failure) {
      blocks_.fail(entry, failure);
    } else {
      const bool was_here_before = blocks_.finish(entry, std::move(blocks[i]), entry->bytes);
      // A block that is read again counts as used again, so that it is packed next time.
      entry->note.reused = entry->note.reused || was_here_before;
    }
  }
}

std::vector<std::shared_ptr<VolumeBlock>> VolumeBuffer::load(std::span<const Own> run,
                                                             ReadTally* tally) {
  std::vector<std::shared_ptr<VolumeBlock>> blocks;
  std::vector<RegionRead> regions, spreads;
  uint64_t voxels = 0;
  for (const Own& own : run) {
    const auto& block = blocks.emplace_back(emptyBlock(own.entry->key));
    const std::span<std::byte> bytes(block->bytes.get(), block->byteCount());
    regions.push_back({block->voxels, bytes.first(block->planeBytes())});
    spreads.push_back({block->voxels, bytes.subspan(block->planeBytes())});
    voxels += static_cast<uint64_t>(block->voxels.count());
  }
  const BlockName& first = run.front().entry->key;
  const Level& level = levelOf(first);
  const auto read = [&](VolumeSource& source, std::span<const RegionRead> wanted) {
    DeviceReader reader(source);
    reader.read(first.time, wanted);
    countRead(reader, voxels * bytesPerVoxel(source.layout().type), tally);
  };
  read(*level.source, regions);
  if (level.spreads != nullptr) read(*level.spreads, spreads);
  if (check_)
    for (size_t i = 0; i < run.size(); ++i) check_(run[i].entry->key, *blocks[i]);
  return blocks;
}

bool VolumeBuffer::holds(const BlockName& key) const {
  const MutexLock lock(blocks_.mutex);
  // Packed blocks count as held: they need no reading.
  if (cold_by_key_.contains(key)) return true;
  const EntryPtr entry = blocks_.find(key);
  return entry != nullptr && entry->state == Blocks::Entry::State::kResident;
}

void VolumeBuffer::readPast(int64_t time, const RegionRead& region, ReadTally* tally) {
  DeviceReader reader(*levels_.front().source);
  reader.read(time, region);
  countRead(reader,
            static_cast<uint64_t>(region.box.count()) *
                bytesPerVoxel(levels_.front().source->layout().type),
            tally);
}

void VolumeBuffer::countRead(const DeviceReader& reader, uint64_t bytes, ReadTally* tally) {
  if (tally != nullptr) {
    tally->read_ns += reader.readNs();
    tally->decode_ns += reader.convertNs();
    tally->decoded_bytes += bytes;
  }
  const MutexLock lock(blocks_.mutex);
  blocks_.countDecoded(bytes);
}

}  // namespace sluice
