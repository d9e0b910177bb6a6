// LearntRanges: the min-max arrays of blocks that become known as pictures read the blocks.
//
// A volume with levels of resolution may be drawn before anybody has passed over its finest level
// (SliceRanges::unknown): anything may show in its blocks then. Each of them that a picture reads
// is noted here, so that the next picture knows what shows in it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/volume/block_name.h"
#include "src/volume/ranges/slice_ranges.h"
#include "src/volume/volume_buffer.h"

namespace sluice {

class LearntRanges {
 public:
  // Arrays beyond this are not noted; their blocks stay unknown.
  static constexpr uint64_t kMostBytes = uint64_t{8} << 20;

  // `known`: the ranges of the finest level of time step `time` so far.
  LearntRanges(int64_t time, std::shared_ptr<const SliceRanges> known)
      : time_(time), known_(std::move(known)) {}

  int64_t time() const { return time_; }
  // Any thread. Blocks of other levels and steps, and those that are known, are ignored.
  void note(const BlockName& name, const VolumeBlock& block) SLUICE_EXCLUDES(mutex_);
  // The ranges with all blocks that were noted so far; the same object while nothing is new. Range
  // and counts of the values stay as they were, so that the look does.
  std::shared_ptr<const SliceRanges> ranges() SLUICE_EXCLUDES(mutex_);

 private:
  // PlaneRange<T> of a block: the total, then [axis][plane].
  using Arrays = std::vector<std::byte>;

  const int64_t time_;
  Mutex mutex_;
  std::shared_ptr<const SliceRanges> known_ SLUICE_GUARDED_BY(mutex_);
  std::map<int64_t, Arrays> fresh_ SLUICE_GUARDED_BY(mutex_);  // not yet in known_, by block
  uint64_t bytes_ SLUICE_GUARDED_BY(mutex_) = 0;               // of all arrays that were noted
};

}  // namespace sluice
