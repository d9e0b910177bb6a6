// StackedArray: arrays of one shape, one for each time step and channel, as one array with these
// two axes in front. Formats of microscopes keep an array for each.
//
// The arrays are opened when they are read, and kept open up to a number of them. Any thread may
// call anything at once.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "io/zarr/reading/chunked_array.h"
#include "src/base/threads/mutex.h"

namespace sluice {

class StackedArray final : public ChunkedArray {
 public:
  // Null: there is no such array; the volume is empty there.
  using Open = std::function<std::unique_ptr<ChunkedArray>(int64_t time, int64_t channel)>;

  // Opens the first array of a channel, as which all must be. `extents`: of the part that is the
  // volume, from the first voxel on; empty: all of it. `name`: in messages. Requires: there is an
  // array of the channel. Throws Error.
  StackedArray(int64_t times, int64_t channels, int64_t channel, std::vector<int64_t> extents,
               Open open, std::string name);

  const ZarrArray& array() const override { return array_; }
  bool areKnown() const override { return false; }
  const std::vector<int64_t>& existing() override;
  bool exists(int64_t chunk) override;
  // Throws Error: an array that differs from the first in shape, chunks or type.
  std::shared_ptr<CountedBytes> load(int64_t chunk, ChunkMemory& memory) override;
  std::string stamp() const override { return stamp_; }
  uint64_t storedBytesRead() const override;

 private:
  struct Part {
    std::shared_ptr<ChunkedArray> array;
    int64_t chunk = 0;
  };
  // The array that has a chunk, opened if need be, and the chunk's number there. No array: the
  // chunk does not exist.
  Part partOf(int64_t chunk);
  std::shared_ptr<ChunkedArray> arrayAt(int64_t time, int64_t channel);
  void closeIdle() SLUICE_REQUIRES(mutex_);

  const Open open_;
  const std::string name_;
  ZarrArray inner_;  // of each array; constant after construction, as all that follows
  ZarrArray array_;
  std::string stamp_;  // of the first array
  mutable Mutex mutex_;
  // By time step and channel.
  std::map<int64_t, std::shared_ptr<ChunkedArray>> arrays_ SLUICE_GUARDED_BY(mutex_);
  uint64_t closed_read_bytes_ SLUICE_GUARDED_BY(mutex_) = 0;  // of arrays closed since
};

}  // namespace sluice
