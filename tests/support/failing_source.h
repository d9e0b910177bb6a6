// FailingSource: a source that goes wrong at chosen reads, to see that the one above neither hangs
// nor swallows it.
//
// The wrapped source must outlive it. Any thread may call any member.
#pragma once

#include <condition_variable>
#include <limits>
#include <mutex>

#include "src/base/sources/volume_source.h"

namespace sluice {

class FailingSource : public VolumeSource {
 public:
  enum class Failure {
    kError,      // throws sluice::Error, as a reader does
    kException,  // throws std::runtime_error, as a library that nobody translated does
    kStall,      // waits for release(), then reads as usual
  };
  static constexpr int64_t kForever = std::numeric_limits<int64_t>::max();

  // Reads first, first + 1, ... (the first read of all is 0), `count` of them, go wrong.
  FailingSource(VolumeSource& source, Failure failure, int64_t first, int64_t count = 1)
      : source_(source), failure_(failure), first_(first), count_(count) {}

  const VolumeLayout& layout() const override { return source_.layout(); }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  std::optional<Occupancy> occupancy(int64_t time) override { return source_.occupancy(time); }
  std::string identity() const override { return source_.identity(); }
  uint64_t storedBytesRead() const override { return source_.storedBytesRead(); }

  // Lets stalled reads go on, those still to come too.
  void release();
  // Returns once a read stands still, so that a test need not sleep.
  void waitUntilStalled();

 private:
  VolumeSource& source_;
  const Failure failure_;
  const int64_t first_, count_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int64_t reads_ = 0;      // guarded by mutex_
  int64_t stalled_ = 0;    // guarded by mutex_
  bool released_ = false;  // guarded by mutex_
};

}  // namespace sluice
