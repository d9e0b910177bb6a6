// OwnThread: a thread on which calls run one after the other, whichever thread they come from. For
// objects that belong to one thread, such as OpenGL contexts. If calls may run on no other thread
// than their caller's, as those of MPI, each runs there.
#pragma once

#include <exception>
#include <functional>
#include <optional>
#include <thread>

#include "src/base/threads/mutex.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

class OwnThread {
 public:
  enum class Runs { kOnOwn, kOnCallers };
  // If the system gives no thread, calls run on their caller's thread.
  explicit OwnThread(Runs runs = Runs::kOnOwn) {
    if (runs == Runs::kOnOwn) worker_.emplace(1);
  }
  OwnThread(const OwnThread&) = delete;
  OwnThread& operator=(const OwnThread&) = delete;

  // Runs `call` and waits for it; other callers wait their turn. Throws what `call` throws, and
  // Error if it is called from within such a call, which would wait for itself.
  void run(const std::function<void()>& call);

 private:
  void execute(const std::function<void()>& call);

  Mutex turn_;  // held for the whole of a call
  Mutex mutex_;
  Condition changed_;
  bool is_done_ SLUICE_GUARDED_BY(mutex_) = false;
  std::exception_ptr failure_ SLUICE_GUARDED_BY(mutex_);
  std::thread::id running_ SLUICE_GUARDED_BY(mutex_);  // on which a call runs now
  std::optional<WorkerPool> worker_;                   // last: joins before the rest goes
};

}  // namespace sluice
