// ProgressMeter: how much of some work is done, counted by those who do it and told to whoever
// watches. What is shown of it, if anything, is the watcher's. expect() and add() may be called
// from any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "src/base/mutex.h"

namespace sluice {

// Told of what is done so far, and what all of it will be as far as known. May throw to end the
// work.
using ProgressWatch = std::function<void(uint64_t done, uint64_t total)>;

class ProgressMeter {
 public:
  // Nobody watches.
  ProgressMeter() = default;
  // `watch` is called by whichever thread adds, one at a time. `total` is what add() will sum up
  // to, as far as known.
  explicit ProgressMeter(ProgressWatch watch, uint64_t total = 0);
  ProgressMeter(const ProgressMeter&) = delete;
  ProgressMeter& operator=(const ProgressMeter&) = delete;

  // More to come than was known at construction.
  void expect(uint64_t more) { total_ += more; }
  void add(uint64_t more);

 private:
  const ProgressWatch watch_;  // may be null
  std::atomic<uint64_t> total_{0}, done_{0};
  Mutex mutex_;  // held while the watcher is told
};

}  // namespace sluice
