// WorkerPool: a fixed number of threads that run loops and background tasks.
//
// Owned by the program and handed down by reference. parallelFor and submit may be called from any
// thread; parallelFor's caller works too, so a pool of 1 runs loops on the caller alone and nested
// loops cannot deadlock.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sluice {

class WorkerPool {
 public:
  // `threads` counts the caller of parallelFor: threads - 1 are started, at least one for submit.
  // 0 means one a core.
  explicit WorkerPool(int threads = 0);
  // Runs what is queued, then joins.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return threads_; }

  // Calls body(i) for each i in [0, count), in any order and on several threads; returns when all
  // are done. The first exception stops the handing out of further i and is rethrown here.
  void parallelFor(int64_t count, const std::function<void(int64_t)>& body);

  // Queues `task` to run on a worker, in order of submission. The task must not throw: it stores
  // its failure where the one who waits looks.
  void submit(std::function<void()> task);

 private:
  void work();

  const int threads_;  // constant after construction
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> queue_;  // guarded by mutex_
  bool stopping_ = false;                    // guarded by mutex_
  std::vector<std::thread> workers_;         // constant after construction
};

}  // namespace sluice
