// CountingSource: the second observer of accounting tests. Wraps a source and counts independently
// what is read through it.
//
// The wrapped source must outlive it. Any thread may call any member.
#pragma once

#include <mutex>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

class CountingSource : public VolumeSource {
 public:
  struct Read {
    int64_t time;
    Box3 box;
    friend bool operator==(const Read&, const Read&) = default;
  };
  struct Counts {
    int64_t calls = 0, voxels = 0, bytes = 0;  // calls that returned
    int64_t failures = 0;                      // calls that threw
    int64_t max_at_once = 0;                   // calls under way at one moment, at most
  };

  explicit CountingSource(VolumeSource& source) : source_(source) {}

  const VolumeLayout& layout() const override { return source_.layout(); }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  // Counts as one call, however many regions.
  void readRegions(int64_t time, std::span<const RegionRead> regions) override;
  std::optional<Occupancy> occupancy(int64_t time) override { return source_.occupancy(time); }
  std::string identity() const override { return source_.identity(); }
  uint64_t storedBytesRead() const override { return source_.storedBytesRead(); }

  Counts counts() const;
  // Each region of the calls that returned, in the order of returning.
  std::vector<Read> reads() const;
  // How often this very box was read.
  int64_t timesRead(int64_t time, const Box3& box) const;
  // Forgets counts and reads. Requires: no call under way.
  void reset();

 private:
  VolumeSource& source_;
  mutable std::mutex mutex_;
  Counts counts_;            // guarded by mutex_
  std::vector<Read> reads_;  // guarded by mutex_
  int64_t under_way_ = 0;    // guarded by mutex_
};

}  // namespace sluice
