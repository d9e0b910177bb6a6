#include "io/zarr/reading/stacked_array.h"

#include <bit>
#include <numeric>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kAxesInFront = 2, kMostOpen = 64;

}  // namespace

StackedArray::StackedArray(int64_t times, int64_t channels, int64_t channel,
                           std::vector<int64_t> extents, Open open, std::string name)
    : open_(std::move(open)), name_(std::move(name)) {
  std::unique_ptr<ChunkedArray> first;
  int64_t time = 0;
  for (; time < times && !first; ++time) first = open_(time, channel);
  SLUICE_CHECK(first);
  stamp_ = first->stamp();
  inner_ = first->array();
  array_ = inner_;
  if (array_.axes() + kAxesInFront > kMostZarrAxes)
    fail("{}: expected arrays of 3 axes, found {}", name_, array_.axes());
  if (!extents.empty()) {
    for (size_t a = 0; a < extents.size(); ++a)
      if (extents.size() != array_.axes() || extents[a] < 1 || extents[a] > array_.shape[a])
        fail("{}: expected a size within the {} voxels of its array, found {}", name_,
             array_.shape[a], extents[a]);
    array_.shape = std::move(extents);
  }
  array_.shape.insert(array_.shape.begin(), {times, channels});
  array_.chunks.insert(array_.chunks.begin(), {1, 1});
  array_.files = array_.chunks;
  // Each array decodes its own shards and byte order, so that the stack has plain chunks.
  array_.shards.reset();
  array_.byte_order = std::endian::native;
  for (size_t& axis : array_.order) axis += kAxesInFront;
  array_.order.insert(array_.order.begin(), {0, 1});
  const MutexLock lock(mutex_);
  arrays_[(time - 1) * channels + channel] = std::move(first);
}

const std::vector<int64_t>& StackedArray::existing() {
  SLUICE_CHECK(areKnown());
  static const std::vector<int64_t> kNone;
  return kNone;
}

std::shared_ptr<ChunkedArray> StackedArray::arrayAt(int64_t time, int64_t channel) {
  const int64_t number = time * array_.shape[1] + channel;
  {
    const MutexLock lock(mutex_);
    if (const auto found = arrays_.find(number); found != arrays_.end()) return found->second;
  }
  // Opened without the lock: another thread may do the same, and the first to finish stays.
  std::shared_ptr<ChunkedArray> opened = open_(time, channel);
  if (!opened) return nullptr;
  const ZarrArray& found = opened->array();
  if (found.shape != inner_.shape || found.chunks != inner_.chunks || found.type != inner_.type)
    fail(
        "{}: the array of time step {} and channel {} differs in size, chunks or type from the "
        "first one",
        name_, time, channel);
  const MutexLock lock(mutex_);
  closeIdle();
  return arrays_.try_emplace(number, std::move(opened)).first->second;
}

void StackedArray::closeIdle() {
  for (auto at = arrays_.begin(); arrays_.size() >= kMostOpen && at != arrays_.end();) {
    // In use elsewhere: its reads are not done, so its count is not final.
    if (at->second.use_count() > 1) {
      ++at;
      continue;
    }
    closed_read_bytes_ += at->second->storedBytesRead();
    at = arrays_.erase(at);
  }
}

StackedArray::Part StackedArray::partOf(int64_t chunk) {
  const std::vector<int64_t> index = array_.chunkIndex(chunk);
  return {arrayAt(index[0], index[1]), inner_.chunkNumber(std::span(index).subspan(kAxesInFront))};
}

bool StackedArray::exists(int64_t chunk) {
  const Part part = partOf(chunk);
  return part.array && part.array->exists(part.chunk);
}

std::shared_ptr<CountedBytes> StackedArray::load(int64_t chunk, ChunkMemory& memory) {
  const Part part = partOf(chunk);
  return part.array->load(part.chunk, memory);
}

uint64_t StackedArray::storedBytesRead() const {
  const MutexLock lock(mutex_);
  uint64_t bytes = closed_read_bytes_;
  for (const auto& [number, array] : arrays_) bytes += array->storedBytesRead();
  return bytes;
}

}  // namespace sluice
