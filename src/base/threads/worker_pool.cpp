#include "src/base/threads/worker_pool.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>
#include <new>
#include <utility>

namespace sluice {
namespace {

// A parallelFor in flight, shared by the caller and the helpers that the queue may start late.
struct Loop {
  int64_t count;
  const std::function<void(int64_t)>* body;  // valid while `finished` < count
  std::atomic<int64_t> next{0};
  Mutex mutex;
  Condition done;
  int64_t finished SLUICE_GUARDED_BY(mutex) = 0;
  std::exception_ptr failure SLUICE_GUARDED_BY(mutex);

  // Takes indices until none is left. After a failure the rest are counted, not run. Takes the lock
  // once: threads that took it at each index would wait for it longer than for short calls.
  void run() {
    int64_t counted = 0;
    std::exception_ptr caught;
    for (int64_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) {
      ++counted;
      try {
        (*body)(i);
      } catch (...) {
        caught = std::current_exception();
        const int64_t from = next.exchange(count);
        if (from < count) counted += count - from;
      }
    }
    if (counted == 0) return;
    const MutexLock lock(mutex);
    if (caught && !failure) failure = caught;
    finished += counted;
    if (finished == count) done.notifyAll();
  }

  // Returns when every call has, rethrows the first failure.
  void wait() {
    MutexLock lock(mutex);
    while (finished < count) done.wait(lock);
    if (failure) std::rethrow_exception(failure);
  }
};

}  // namespace

WorkerPool::WorkerPool(int threads, const ThreadStarter& start)
    : wanted_threads_(threads > 0 ? threads : processorCount()),
      workers_(startThreads(
          std::max(wanted_threads_ - 1, 1), [this] { work(); }, start)),
      threads_(std::min(wanted_threads_, static_cast<int>(workers_.size()) + 1)) {}

WorkerPool::~WorkerPool() {
  {
    const MutexLock lock(mutex_);
    stopping_ = true;
  }
  wake_.notifyAll();
  for (std::thread& worker : workers_) worker.join();
}

int WorkerPool::self() const {
  for (size_t i = 0; i < workers_.size(); ++i)
    if (workers_[i].get_id() == std::this_thread::get_id()) return static_cast<int>(i) + 1;
  return 0;
}

void WorkerPool::submit(std::function<void()> task) {
  if (workers_.empty()) {
    task();
    return;
  }
  {
    const MutexLock lock(mutex_);
    queue_.push_back(std::move(task));
  }
  wake_.notifyOne();
}

void WorkerPool::parallelFor(int64_t count, const std::function<void(int64_t)>& body) {
  if (count <= 0) return;
  auto loop = std::make_shared<Loop>();
  loop->count = count;
  loop->body = &body;
  const int64_t helpers = std::min<int64_t>(threads_ - 1, count - 1);
  // The queue may start helpers late or never: the caller takes indices itself, so that a loop
  // within a loop ends even if all workers are busy.
  try {
    for (int64_t i = 0; i < helpers; ++i) submit([loop] { loop->run(); });
  } catch (const std::bad_alloc&) {
    // Helpers that are in the queue already refer to `body`, so the loop goes on with these.
  }
  loop->run();
  loop->wait();
}

void WorkerPool::work() {
  for (;;) {
    std::function<void()> task;
    {
      MutexLock lock(mutex_);
      while (!stopping_ && queue_.empty()) wake_.wait(lock);
      // Only once the queue is empty: tasks that were submitted are run before the end.
      if (queue_.empty()) return;
      task = std::move(queue_.front());
      queue_.pop_front();
    }
    task();
  }
}

}  // namespace sluice
