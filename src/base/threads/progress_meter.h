// ProgressMeter counts how much of some work is done: workers add to it, a watcher reads it. The
// watcher decides what to show. expect() and add() may be called from any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "src/base/threads/mutex.h"

namespace sluice {

// Called with the work done so far and the total as far as known. May throw to end the work.
using ProgressWatch = std::function<void(uint64_t done, uint64_t total)>;

class ProgressMeter {
 public:
  // A meter that nobody watches.
  ProgressMeter() = default;
  // `watch` is called by whichever thread adds, one at a time. `total` is the sum that add() will
  // reach, as far as known.
  explicit ProgressMeter(ProgressWatch watch, uint64_t total = 0);
  ProgressMeter(const ProgressMeter&) = delete;
  ProgressMeter& operator=(const ProgressMeter&) = delete;

  // Adds work that was not known at construction.
  void expect(uint64_t more) { total_ += more; }
  void add(uint64_t more);

 private:
  const ProgressWatch watch_;  // may be null
  std::atomic<uint64_t> total_{0}, done_{0};
  Mutex mutex_;  // held while the watcher is told
};

}  // namespace sluice
