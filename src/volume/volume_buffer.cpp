#include "src/volume/volume_buffer.h"

#include <algorithm>
#include <cstring>

#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"

namespace sluice {

// Its fields but the first are guarded by the buffer's mutex; `block` is constant once published.
struct VolumeBuffer::Entry {
  BlockKey key;
  uint64_t bytes = 0;
  enum class State { kLoading, kResident, kFailed } state = State::kLoading;
  VolumeBlockPtr block;
  std::string failure;
  std::list<EntryPtr>::iterator place;  // in recent_ while resident
};

VolumeBuffer::VolumeBuffer(VolumeSource& source, const BlockLayout& layout, uint64_t budget_bytes)
    : source_(source), layout_(layout), map_(deviceMap(source.layout())) {
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

void VolumeBuffer::makeRoom(uint64_t bytes) {
  auto victim = recent_.end();
  while (counters_.current_bytes + reserved_bytes_ + bytes > counters_.budget_bytes) {
    // Only this cache holds it: no one can gain a handle while we hold the mutex.
    do {
      if (victim == recent_.begin())
        fail(
            "the volume buffer of {} cannot hold {} more beside the {} in use; give more --memory "
            "or a smaller --block",
            formatBytes(counters_.budget_bytes), formatBytes(bytes),
            formatBytes(counters_.current_bytes + reserved_bytes_));
      --victim;
    } while ((*victim)->block.use_count() > 1);
    counters_.countEviction((*victim)->bytes);
    entries_.erase((*victim)->key);
    victim = recent_.erase(victim);
  }
}

VolumeBuffer::EntryPtr VolumeBuffer::publish(const BlockKey& key) {
  const Box3 voxels = layout_.storedVoxels(layout_.indexOf(key.block));
  const uint64_t bytes = static_cast<uint64_t>(voxels.count()) * bytesPerVoxel(map_.type);
  makeRoom(bytes);
  auto entry = std::make_shared<Entry>();
  entry->key = key;
  entry->bytes = bytes;
  reserved_bytes_ += bytes;
  entries_.emplace(key, entry);
  return entry;
}

std::vector<VolumeBlockPtr> VolumeBuffer::acquire(std::span<const BlockKey> keys) {
  std::vector<EntryPtr> wanted;
  std::vector<EntryPtr> ours;
  std::vector<VolumeBlockPtr> pins;  // hits, so that making room for the rest does not evict them
  std::string no_room;
  {
    std::lock_guard lock(mutex_);
    for (const BlockKey& key : keys) {
      const auto found = entries_.find(key);
      if (found == entries_.end()) {
        counters_.countMiss();
        try {
          wanted.push_back(publish(key));
        } catch (const Error& error) {
          counters_.countFailure();
          no_room = error.what();
          break;
        }
        ours.push_back(wanted.back());
      } else if (found->second->state == Entry::State::kResident) {
        counters_.countHit();
        recent_.splice(recent_.begin(), recent_, found->second->place);
        pins.push_back(found->second->block);
        wanted.push_back(found->second);
      } else {
        counters_.countMiss();
        counters_.countCoalesced();
        wanted.push_back(found->second);
      }
    }
  }
  // What was published must be brought to an end also when there is no room for the rest.
  for (size_t from = 0; from < ours.size();) {
    size_t to = from + 1;
    const auto follows = [&](const Entry& a, const Entry& b) {
      return a.key.time == b.key.time && b.key.block == a.key.block + 1 &&
             b.key.block % layout_.grid.x != 0;
    };
    while (to < ours.size() && follows(*ours[to - 1], *ours[to])) ++to;
    const std::span<const EntryPtr> run(ours.data() + from, to - from);
    std::string failure;
    try {
      load(run);
    } catch (const std::exception& error) {
      failure = error.what();
    }
    finish(run, failure);
    from = to;
  }
  if (!no_room.empty()) throw Error(no_room);

  std::vector<VolumeBlockPtr> blocks;
  std::unique_lock lock(mutex_);
  for (const EntryPtr& entry : wanted) {
    loaded_.wait(lock, [&] { return entry->state != Entry::State::kLoading; });
    if (entry->state == Entry::State::kFailed) throw Error(entry->failure);
    blocks.push_back(entry->block);
  }
  return blocks;
}

void VolumeBuffer::load(std::span<const EntryPtr> run) {
  Box3 box;
  std::vector<std::shared_ptr<VolumeBlock>> blocks;
  for (const EntryPtr& entry : run) {
    auto block = std::make_shared<VolumeBlock>();
    block->voxels = layout_.storedVoxels(layout_.indexOf(entry->key.block));
    block->type = map_.type;
    block->bytes = std::make_unique_for_overwrite<std::byte[]>(block->byteCount());
    box = unite(box, block->voxels);
    blocks.push_back(std::move(block));
  }
  const VoxelType stored_type = source_.layout().type;
  const size_t stored_size = bytesPerVoxel(stored_type), device_size = bytesPerVoxel(map_.type);
  const auto stored_bytes = static_cast<size_t>(box.count()) * stored_size;
  const int64_t time = run.front()->key.time;
  const bool as_it_is =
      run.size() == 1 && (stored_type == VoxelType::kU8 || stored_type == VoxelType::kU16);
  Stopwatch watch;
  const auto nanoseconds = [&watch] { return static_cast<int64_t>(watch.lap() * 1e9); };
  if (as_it_is) {
    source_.readRegion(time, box, {blocks[0]->bytes.get(), stored_bytes});
    read_ns_ += nanoseconds();
  } else {
    const auto stored = std::make_unique_for_overwrite<std::byte[]>(stored_bytes);
    source_.readRegion(time, box, {stored.get(), stored_bytes});
    read_ns_ += nanoseconds();
    const Vec3i size = box.size();
    for (const auto& block : blocks) {
      const Vec3i from = block->voxels.lo - box.lo, own = block->voxels.size();
      std::byte* to = block->bytes.get();
      for (int64_t z = 0; z < own.z; ++z)
        for (int64_t y = 0; y < own.y; ++y) {
          const auto at =
              static_cast<size_t>(((from.z + z) * size.y + from.y + y) * size.x + from.x);
          const auto row = static_cast<size_t>(own.x);
          toDevice(stored_type, {stored.get() + at * stored_size, row * stored_size},
                   {to, row * device_size});
          to += row * device_size;
        }
    }
    decode_ns_ += nanoseconds();
  }
  std::lock_guard lock(mutex_);
  for (size_t i = 0; i < run.size(); ++i) run[i]->block = std::move(blocks[i]);
  counters_.decoded_bytes += stored_bytes;
}

void VolumeBuffer::finish(std::span<const EntryPtr> run, const std::string& failure) {
  {
    std::lock_guard lock(mutex_);
    for (const EntryPtr& entry : run) {
      reserved_bytes_ -= entry->bytes;
      if (failure.empty()) {
        entry->state = Entry::State::kResident;
        recent_.push_front(entry);
        entry->place = recent_.begin();
        counters_.countLoad(entry->bytes, !seen_.insert(entry->key).second);
      } else {
        entry->state = Entry::State::kFailed;
        entry->failure = failure;
        entries_.erase(entry->key);
        counters_.countFailure();
      }
    }
  }
  loaded_.notify_all();
}

}  // namespace sluice
