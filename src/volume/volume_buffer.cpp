#include "src/volume/volume_buffer.h"

#include <algorithm>
#include <utility>

#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/volume/packed_block.h"

namespace sluice {

namespace {

// Seconds since construction or the last call, in ns.
class Laps {
 public:
  int64_t operator()() { return static_cast<int64_t>(watch_.lap() * 1e9); }

 private:
  Stopwatch watch_;
};

}  // namespace

// `key` and `bytes` are constant after construction, the rest is guarded by the buffer's mutex.
struct VolumeBuffer::Entry {
  BlockKey key;
  uint64_t bytes = 0;  // as it is
  enum class State { kLoading, kResident, kPacked, kFailed } state = State::kLoading;
  VolumeBlockPtr block;                 // when kResident
  PackedBytes packed;                   // when kPacked, and while it is unpacked (kLoading)
  bool used = false;                    // asked for, not only ahead
  bool reused = false;                  // used again, now or after an earlier load
  bool being_packed = false;            // kResident, but not in recent_
  std::exception_ptr failure;           // Error or Interrupted, when kFailed
  int64_t wanted_by = 0;                // calls of acquire that have not yet taken `block`
  std::list<EntryPtr>::iterator place;  // in recent_ or cold_

  // No one can gain a handle but by wanting it first.
  bool isFree() const { return wanted_by == 0 && (block == nullptr || block.use_count() == 1); }
};

VolumeBuffer::VolumeBuffer(VolumeSource& source, const BlockLayout& layout, uint64_t budget_bytes,
                           Cold cold)
    : source_(source),
      layout_(layout),
      map_(deviceMap(source.layout())),
      packs_(cold == Cold::kPacked && budget_bytes >= 16 * blockBytes()),
      memory_(BufferMemory::make(budget_bytes)) {
  counters_.budget_bytes = budget_bytes;
}
VolumeBuffer::~VolumeBuffer() = default;

uint64_t VolumeBuffer::blockBytes() const {
  return static_cast<uint64_t>(volume(Vec3i{layout_.size, layout_.size, layout_.size})) *
         bytesPerVoxel(map_.type);
}

CacheCounters VolumeBuffer::counters() const {
  std::lock_guard lock(mutex_);
  return counters_;
}

void VolumeBuffer::resetCounters() {
  std::lock_guard lock(mutex_);
  counters_.reset();
}

bool VolumeBuffer::hasRoom(uint64_t bytes) const {
  const uint64_t scratch = packs_ ? blockBytes() : 0;
  return counters_.current_bytes + reserved_bytes_ + scratch + bytes <= counters_.budget_bytes;
}

void VolumeBuffer::countPacked(int64_t bytes) {
  packed_bytes_ += static_cast<uint64_t>(bytes);
  const uint64_t scratch = packs_ ? blockBytes() : 0;
  memory_->setLimit(counters_.budget_bytes - scratch - packed_bytes_);
}

void VolumeBuffer::freeSome(std::unique_lock<std::mutex>& lock, uint64_t wanted_bytes) {
  const auto coldest = [](const std::list<EntryPtr>& entries) -> EntryPtr {
    for (auto at = entries.rbegin(); at != entries.rend(); ++at)
      if ((*at)->isFree()) return *at;
    return nullptr;
  };
  const EntryPtr victim = coldest(recent_);
  if (victim == nullptr || cold_bytes_ > counters_.budget_bytes / 2) {
    const EntryPtr packed = coldest(cold_);
    if (packed != nullptr) {
      cold_bytes_ -= packed->packed.byte_count;
      drop(packed, cold_);
      return;
    }
  }
  if (victim != nullptr) {
    packOrDrop(lock, victim);
  } else if (packing_) {
    loaded_.wait(lock, [&] { return !packing_; });
  } else {
    fail(
        "the volume buffer of {} cannot hold {} more beside the {} in use; give more --memory or a "
        "smaller --block",
        formatBytes(counters_.budget_bytes), formatBytes(wanted_bytes),
        formatBytes(counters_.current_bytes + reserved_bytes_));
  }
}

void VolumeBuffer::drop(const EntryPtr& victim, std::list<EntryPtr>& from) {
  const bool is_packed = victim->state == Entry::State::kPacked;
  counters_.countEviction(is_packed ? victim->packed.byte_count : victim->bytes);
  if (is_packed) countPacked(-static_cast<int64_t>(victim->packed.byte_count));
  from.erase(victim->place);
  entries_.erase(victim->key);
}

void VolumeBuffer::packOrDrop(std::unique_lock<std::mutex>& lock, const EntryPtr& victim) {
  if (!packs_ || !victim->reused) {
    drop(victim, recent_);
    return;
  }
  if (packing_) {
    loaded_.wait(lock, [&] { return !packing_; });
    return;
  }
  packing_ = victim->being_packed = true;
  recent_.erase(victim->place);
  const VolumeBlock& block = *victim->block;
  lock.unlock();
  std::optional<PackedBytes> packed =
      pack({block.bytes.get(), block.byteCount()}, bytesPerVoxel(block.type));
  lock.lock();
  packing_ = victim->being_packed = false;
  recent_.push_front(victim);
  victim->place = recent_.begin();
  if (victim->isFree()) {  // else someone wanted it in the meantime
    if (packed) {
      counters_.countPack(victim->bytes, packed->byte_count);
      victim->state = Entry::State::kPacked;
      victim->block.reset();
      victim->packed = std::move(*packed);
      cold_bytes_ += victim->packed.byte_count;
      countPacked(static_cast<int64_t>(victim->packed.byte_count));
      cold_.splice(cold_.begin(), recent_, victim->place);
    } else {
      drop(victim, recent_);
    }
  }
  loaded_.notify_all();
}

VolumeBuffer::EntryPtr VolumeBuffer::request(std::unique_lock<std::mutex>& lock,
                                             const BlockKey& key, bool ahead,
                                             std::vector<EntryPtr>& ours) {
  const Box3 voxels = layout_.storedVoxels(layout_.indexOf(key.block));
  const uint64_t bytes = static_cast<uint64_t>(voxels.count()) * bytesPerVoxel(map_.type);
  for (;;) {  // what is found may change while room is made
    const auto found = entries_.find(key);
    EntryPtr entry = found == entries_.end() ? nullptr : found->second;
    if (entry != nullptr && !ahead) {
      entry->reused = entry->reused || entry->used;
      entry->used = true;
    }
    if (entry != nullptr && entry->state == Entry::State::kResident) {
      counters_.countHit();
      if (!entry->being_packed) recent_.splice(recent_.begin(), recent_, entry->place);
      return entry;
    }
    if (entry != nullptr && entry->state == Entry::State::kLoading) {
      // One that is being unpacked is resident.
      if (entry->packed.bytes != nullptr) {
        counters_.countHit();
      } else {
        counters_.countMiss();
        counters_.countCoalesced();
      }
      return entry;
    }
    if (!hasRoom(bytes)) {
      try {
        freeSome(lock, bytes);
      } catch (const Error&) {
        counters_.countMiss();
        counters_.countFailure();
        throw;
      }
      continue;
    }
    reserved_bytes_ += bytes;
    if (entry != nullptr) {  // packed
      counters_.countHit();
      cold_bytes_ -= entry->packed.byte_count;
      cold_.erase(entry->place);
      entry->state = Entry::State::kLoading;
      ours.push_back(entry);
      return entry;
    }
    counters_.countMiss();
    auto fresh = std::make_shared<Entry>();
    fresh->key = key;
    fresh->bytes = bytes;
    fresh->used = !ahead;
    entries_.emplace(key, fresh);
    ours.push_back(fresh);
    return fresh;
  }
}

std::vector<VolumeBlockPtr> VolumeBuffer::acquire(std::span<const BlockKey> keys,
                                                  const std::vector<bool>& ahead) {
  std::vector<EntryPtr> wanted;
  std::vector<EntryPtr> ours;
  std::exception_ptr failure;
  {
    std::unique_lock lock(mutex_);
    for (size_t i = 0; i < keys.size(); ++i) {
      try {
        wanted.push_back(request(lock, keys[i], !ahead.empty() && ahead[i], ours));
      } catch (const Error&) {
        failure = std::current_exception();
        break;
      }
      ++wanted.back()->wanted_by;
    }
  }
  // What was published must be brought to an end also when there is no room for the rest.
  loadOwn(ours);

  std::vector<VolumeBlockPtr> blocks;
  std::unique_lock lock(mutex_);
  for (const EntryPtr& entry : wanted) {
    if (!failure) {
      loaded_.wait(lock, [&] { return entry->state != Entry::State::kLoading; });
      failure = entry->failure;
      blocks.push_back(entry->block);
    }
    --entry->wanted_by;
  }
  lock.unlock();
  if (failure) std::rethrow_exception(failure);
  return blocks;
}

void VolumeBuffer::loadOwn(std::span<const EntryPtr> ours) {
  const auto besideEachOther = [&](const Entry& a, const Entry& b) {
    return a.key.time == b.key.time && a.key.block / layout_.grid.x == b.key.block / layout_.grid.x;
  };
  for (size_t from = 0; from < ours.size();) {
    if (ours[from]->packed.bytes != nullptr) {
      unpackAndFinish(ours[from++]);
      continue;
    }
    size_t to = from + 1;
    while (to < ours.size() && ours[to]->packed.bytes == nullptr &&
           besideEachOther(*ours[from], *ours[to]))
      ++to;
    loadAndFinish(ours.subspan(from, to - from));
    from = to;
  }
}

std::shared_ptr<VolumeBlock> VolumeBuffer::emptyBlock(const BlockKey& key) const {
  auto block = std::make_shared<VolumeBlock>();
  block->voxels = layout_.storedVoxels(layout_.indexOf(key.block));
  block->type = map_.type;
  block->bytes = memory_->take(block->byteCount());
  return block;
}

void VolumeBuffer::hold(const EntryPtr& entry, VolumeBlockPtr block) {
  reserved_bytes_ -= entry->bytes;
  entry->state = Entry::State::kResident;
  entry->block = std::move(block);
  recent_.push_front(entry);
  entry->place = recent_.begin();
}

void VolumeBuffer::unpackAndFinish(const EntryPtr& entry) {
  Laps nanoseconds;
  std::shared_ptr<VolumeBlock> block;
  std::exception_ptr failure;
  try {
    block = emptyBlock(entry->key);
    unpack(entry->packed, {block->bytes.get(), block->byteCount()});
  } catch (...) {  // no memory: those who wait must hear of it
    failure = std::current_exception();
  }
  decode_ns_ += nanoseconds();
  {
    std::lock_guard lock(mutex_);
    if (failure) {
      reserved_bytes_ -= entry->bytes;
      counters_.countEviction(entry->packed.byte_count);
      entry->state = Entry::State::kFailed;
      entry->failure = failure;
      entries_.erase(entry->key);
    } else {
      hold(entry, block);
      counters_.countUnpack(entry->packed.byte_count, entry->bytes);
    }
    countPacked(-static_cast<int64_t>(entry->packed.byte_count));
    entry->packed = {};
  }
  loaded_.notify_all();
}

void VolumeBuffer::loadAndFinish(std::span<const EntryPtr> run) {
  std::vector<std::shared_ptr<VolumeBlock>> blocks;
  std::exception_ptr failure;
  try {
    blocks = load(run);
  } catch (const Error&) {
    failure = std::current_exception();
  } catch (const Interrupted&) {
    failure = std::current_exception();
  } catch (const std::exception& error) {
    failure = std::make_exception_ptr(Error(fmt::format("{}: block {}: {}", source_.layout().name,
                                                        run.front()->key.block, error.what())));
  }
  {
    std::lock_guard lock(mutex_);
    for (size_t i = 0; i < run.size(); ++i) {
      Entry& entry = *run[i];
      if (failure) {
        reserved_bytes_ -= entry.bytes;
        entry.state = Entry::State::kFailed;
        entry.failure = failure;
        entries_.erase(entry.key);
        counters_.countFailure();
      } else {
        hold(run[i], std::move(blocks[i]));
        const bool was_here_before = !seen_.insert(entry.key).second;
        entry.reused = entry.reused || was_here_before;
        counters_.countLoad(entry.bytes, was_here_before);
      }
    }
  }
  loaded_.notify_all();
}

std::vector<std::shared_ptr<VolumeBlock>> VolumeBuffer::load(std::span<const EntryPtr> run) {
  std::vector<std::shared_ptr<VolumeBlock>> blocks;
  uint64_t voxels = 0;
  for (const EntryPtr& entry : run) {
    blocks.push_back(emptyBlock(entry->key));
    voxels += static_cast<uint64_t>(blocks.back()->voxels.count());
  }
  const int64_t time = run.front()->key.time;
  const VoxelType type = source_.layout().type;
  if (bytesPerVoxel(type) == bytesPerVoxel(map_.type)) {
    readInPlace(time, blocks);
  } else {
    for (const auto& block : blocks) readThroughScratch(time, *block);
  }
  std::lock_guard lock(mutex_);
  counters_.decoded_bytes += voxels * bytesPerVoxel(type);
  return blocks;
}

void VolumeBuffer::readInPlace(int64_t time, std::span<const std::shared_ptr<VolumeBlock>> blocks) {
  Laps nanoseconds;
  std::vector<RegionRead> regions;
  for (const auto& block : blocks)
    regions.push_back({block->voxels, {block->bytes.get(), block->byteCount()}});
  source_.readRegions(time, regions);
  read_ns_ += nanoseconds();
  const VoxelType type = source_.layout().type;
  if (isStoredAsDevice(type)) return;
  for (const RegionRead& region : regions) toDevice(type, region.out, region.out);
  decode_ns_ += nanoseconds();
}

void VolumeBuffer::readThroughScratch(int64_t time, VolumeBlock& block) {
  const VoxelType type = source_.layout().type;
  const Box3& box = block.voxels;
  const auto plane_voxels = static_cast<size_t>(box.size().x * box.size().y);
  const size_t plane_bytes = plane_voxels * bytesPerVoxel(type);
  const auto planes = static_cast<int64_t>(std::max<size_t>(1, kScratchBytes / plane_bytes));
  const auto scratch = std::make_unique_for_overwrite<std::byte[]>(
      plane_bytes * static_cast<size_t>(std::min(planes, box.size().z)));
  Laps nanoseconds;
  for (int64_t z = box.lo.z; z < box.hi.z; z += planes) {
    const Box3 slab{{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, std::min(z + planes, box.hi.z)}};
    const auto count = static_cast<size_t>(slab.count());
    const std::span stored(scratch.get(), count * bytesPerVoxel(type));
    source_.readRegion(time, slab, stored);
    read_ns_ += nanoseconds();
    std::byte* to = block.bytes.get() + block.offsetOf(slab.lo);
    toDevice(type, stored, {to, count * bytesPerVoxel(map_.type)});
    decode_ns_ += nanoseconds();
  }
}

}  // namespace sluice
