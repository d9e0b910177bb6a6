// Deadline: a stop token that is asked to stop at a point in time, or as soon as another token is.
//
// For work that is worth nothing once the time is over. One thread of its own waits; without a
// thread from the system the token follows the time only when it is asked through isOver(). Any
// thread may use the token, which may outlive the deadline.
#pragma once

#include <chrono>
#include <optional>
#include <thread>

#include "src/base/threads/mutex.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

class Deadline {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  // `until` unset: there is no limit; the token is `stop` itself.
  Deadline(std::optional<TimePoint> until, StopToken stop);
  ~Deadline();
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  StopToken token() const { return until_ ? source_.token() : stop_; }
  bool isOver() const { return until_ && std::chrono::steady_clock::now() >= *until_; }
  // Seconds that are left, 0 at the least; unset without a limit.
  std::optional<double> secondsLeft() const;
  // Whether the other token was asked to stop.
  bool isStopped() const { return stop_.isStopRequested(); }

 private:
  void watch() SLUICE_EXCLUDES(mutex_);

  const std::optional<TimePoint> until_;
  const StopToken stop_;
  StopSource source_;
  Mutex mutex_;
  Condition ended_;
  bool is_ended_ SLUICE_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace sluice
