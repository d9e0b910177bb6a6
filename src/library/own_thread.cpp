#include "src/library/own_thread.h"

#include <utility>

#include "src/base/error.h"

namespace sluice {

void OwnThread::run(const std::function<void()>& call) {
  {
    const MutexLock lock(mutex_);
    if (running_ == std::this_thread::get_id())
      failRequest("called from within a call that is under way, as its progress function is");
  }
  const MutexLock turn(turn_);
  {
    const MutexLock lock(mutex_);
    is_done_ = false;
    failure_ = nullptr;
  }
  if (worker_)
    worker_->submit([this, &call] { execute(call); });
  else
    execute(call);
  MutexLock lock(mutex_);
  while (!is_done_) changed_.wait(lock);
  if (failure_ != nullptr) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void OwnThread::execute(const std::function<void()>& call) {
  {
    const MutexLock lock(mutex_);
    running_ = std::this_thread::get_id();
  }
  std::exception_ptr failure;
  try {
    call();
  } catch (...) {
    failure = std::current_exception();
  }
  // The waiting thread is told under the lock, since it may be gone right after.
  const MutexLock lock(mutex_);
  running_ = {};
  failure_ = std::move(failure);
  is_done_ = true;
  changed_.notifyAll();
}

}  // namespace sluice
