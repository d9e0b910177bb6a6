// Progress: one line on a terminal with share, rate and time left; silent when standard error is
// none. expect() and add() may be called from any thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>

#include "src/base/clock.h"

namespace sluice {

class Progress {
 public:
  // Shows nothing. For library calls whose caller does not watch.
  Progress() = default;
  // `total_bytes` is what add() will sum up to, as far as known; the line appears after half a
  // second.
  explicit Progress(std::string label, uint64_t total_bytes = 0);
  // Wipes the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // More to come than was known at construction.
  void expect(uint64_t bytes) { total_bytes_ += bytes; }
  void add(uint64_t bytes);

 private:
  void draw(uint64_t done);

  const std::string label_;
  const bool visible_ = false;
  const Stopwatch watch_{};
  std::atomic<uint64_t> total_bytes_{0}, done_bytes_{0};
  std::mutex mutex_;
  double drawn_at_s_ = 0;  // guarded by mutex_; 0: never drawn
};

}  // namespace sluice
