#include "src/base/threads/deadline.h"

#include <algorithm>
#include <new>
#include <system_error>
#include <utility>

#include "src/base/threads/threads.h"

namespace sluice {
namespace {

// How often the other token is looked at, which has nobody to wake us.
constexpr std::chrono::milliseconds kLook{5};

}  // namespace

Deadline::Deadline(std::optional<TimePoint> until, StopToken stop)
    : until_(until), stop_(std::move(stop)) {
  if (!until_) return;
  try {
    thread_ = startThread([this] { watch(); });
  } catch (const std::system_error&) {  // isOver() is all that is left
  } catch (const std::bad_alloc&) {
  }
}

Deadline::~Deadline() {
  {
    const MutexLock lock(mutex_);
    is_ended_ = true;
  }
  ended_.notifyAll();
  if (thread_.joinable()) thread_.join();
}

std::optional<double> Deadline::secondsLeft() const {
  if (!until_) return std::nullopt;
  const std::chrono::duration<double> left = *until_ - std::chrono::steady_clock::now();
  return std::max(0.0, left.count());
}

void Deadline::watch() {
  MutexLock lock(mutex_);
  while (!is_ended_ && !isOver() && !stop_.isStopRequested())
    ended_.waitUntil(lock, std::min(*until_, std::chrono::steady_clock::now() + kLook));
  if (!is_ended_) source_.requestStop();
}

}  // namespace sluice
