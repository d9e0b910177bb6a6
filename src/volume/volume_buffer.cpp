#include "src/volume/volume_buffer.h"

#include <algorithm>
#include <utility>

#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"

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
  uint64_t bytes = 0;
  enum class State { kLoading, kResident, kFailed } state = State::kLoading;
  VolumeBlockPtr block;
  std::exception_ptr failure;           // Error or Interrupted, when kFailed
  int64_t wanted_by = 0;                // calls of acquire that have not yet taken `block`
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
    do {
      if (victim == recent_.begin())
        fail(
            "the volume buffer of {} cannot hold {} more beside the {} in use; give more --memory "
            "or a smaller --block",
            formatBytes(counters_.budget_bytes), formatBytes(bytes),
            formatBytes(counters_.current_bytes + reserved_bytes_));
      --victim;
      // Not one that a handle pins, or that a call is about to take: no one can gain a handle
      // otherwise while we hold the mutex.
    } while ((*victim)->wanted_by > 0 || (*victim)->block.use_count() > 1);
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
  std::exception_ptr failure;
  {
    std::lock_guard lock(mutex_);
    for (const BlockKey& key : keys) {
      const auto found = entries_.find(key);
      if (found == entries_.end()) {
        counters_.countMiss();
        try {
          wanted.push_back(publish(key));
        } catch (const Error&) {
          counters_.countFailure();
          failure = std::current_exception();
          break;
        }
        ours.push_back(wanted.back());
      } else if (found->second->state == Entry::State::kResident) {
        counters_.countHit();
        recent_.splice(recent_.begin(), recent_, found->second->place);
        wanted.push_back(found->second);
      } else {
        counters_.countMiss();
        counters_.countCoalesced();
        wanted.push_back(found->second);
      }
      ++wanted.back()->wanted_by;
    }
  }
  // What was published must be brought to an end also when there is no room for the rest.
  for (size_t from = 0; from < ours.size();) {
    size_t to = from + 1;
    const auto besideEachOther = [&](const Entry& a, const Entry& b) {
      return a.key.time == b.key.time &&
             a.key.block / layout_.grid.x == b.key.block / layout_.grid.x;
    };
    while (to < ours.size() && besideEachOther(*ours[to - 1], *ours[to])) ++to;
    loadAndFinish({ours.data() + from, to - from});
    from = to;
  }

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
      reserved_bytes_ -= entry.bytes;
      if (failure) {
        entry.state = Entry::State::kFailed;
        entry.failure = failure;
        entries_.erase(entry.key);
        counters_.countFailure();
      } else {
        entry.state = Entry::State::kResident;
        entry.block = std::move(blocks[i]);
        recent_.push_front(run[i]);
        entry.place = recent_.begin();
        counters_.countLoad(entry.bytes, !seen_.insert(entry.key).second);
      }
    }
  }
  loaded_.notify_all();
}

std::vector<std::shared_ptr<VolumeBlock>> VolumeBuffer::load(std::span<const EntryPtr> run) {
  std::vector<std::shared_ptr<VolumeBlock>> blocks;
  uint64_t voxels = 0;
  for (const EntryPtr& entry : run) {
    auto block = std::make_shared<VolumeBlock>();
    block->voxels = layout_.storedVoxels(layout_.indexOf(entry->key.block));
    block->type = map_.type;
    block->bytes = std::make_unique_for_overwrite<std::byte[]>(block->byteCount());
    voxels += static_cast<uint64_t>(block->voxels.count());
    blocks.push_back(std::move(block));
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
