// WorkerPool: a fixed number of threads that run loops and background tasks.
//
// Owned by the program and handed down by reference. parallelFor and submit may be called from any
// thread; parallelFor's caller works too, so a pool of 1 runs loops on the caller alone and nested
// loops cannot deadlock. If the system starts fewer threads than were asked for, the pool has
// those; a pool without any runs each task where it is submitted.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "src/base/threads/mutex.h"
#include "src/base/threads/threads.h"

namespace sluice {

class WorkerPool {
 public:
  // `threads` counts the caller of parallelFor: threads - 1 are started, at least one for submit.
  // 0 means one a core.
  explicit WorkerPool(int threads = 0, const ThreadStarter& start = startThread);
  // Runs the queued tasks, then joins.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // The number of threads that a loop runs on, its caller included, and the number if all had
  // started.
  int threads() const { return threads_; }
  int wantedThreads() const { return wanted_threads_; }
  // Which of its threads this one is: 1 and more on a worker, else 0. The number is below
  // threads(), except that a task of a pool of one gets 1. Not to be asked in tasks that the
  // destructor still runs.
  int self() const;

  // Calls body(i) for each i in [0, count), in any order and on several threads; returns when all
  // are done. The first exception stops the handing out of further i and is rethrown here.
  void parallelFor(int64_t count, const std::function<void(int64_t)>& body);

  // Queues `task` to run on a worker, in order of submission; a pool without workers runs it here
  // and now. The task must not throw: it stores its failure for the waiting thread.
  void submit(std::function<void()> task);

 private:
  void work();

  const int wanted_threads_;
  Mutex mutex_;
  Condition wake_;
  std::deque<std::function<void()>> queue_ SLUICE_GUARDED_BY(mutex_);
  bool stopping_ SLUICE_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> workers_;  // constant after construction
  int threads_ = 1;                   // constant after construction
};

}  // namespace sluice
