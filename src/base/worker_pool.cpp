#include "src/base/worker_pool.h"

#include <atomic>
#include <exception>
#include <memory>
#include <utility>

namespace sluice {
namespace {

// One parallelFor in flight, shared by the caller and the helpers that the queue may start late.
struct Loop {
  int64_t count;
  const std::function<void(int64_t)>* body;  // valid while `finished` < count
  std::atomic<int64_t> next{0};
  std::mutex mutex;
  std::condition_variable done;
  int64_t finished = 0;        // guarded by mutex
  std::exception_ptr failure;  // guarded by mutex

  // Takes indices until none is left. After a failure the rest are counted, not run.
  void run() {
    for (int64_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) {
      std::exception_ptr caught;
      try {
        (*body)(i);
      } catch (...) {
        caught = std::current_exception();
      }
      int64_t counted = 1;
      if (caught) {
        const int64_t from = next.exchange(count);
        if (from < count) counted += count - from;
      }
      std::lock_guard lock(mutex);
      if (caught && !failure) failure = caught;
      finished += counted;
      if (finished == count) done.notify_all();
    }
  }
};

int workerCount(int threads) {
  if (threads > 0) return threads;
  const unsigned cores = std::thread::hardware_concurrency();
  return cores == 0 ? 1 : static_cast<int>(cores);
}

}  // namespace

WorkerPool::WorkerPool(int threads) : threads_(workerCount(threads)) {
  const int started = threads_ > 1 ? threads_ - 1 : 1;
  for (int i = 0; i < started; ++i) workers_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void WorkerPool::submit(std::function<void()> task) {
  {
    std::lock_guard lock(mutex_);
    queue_.push_back(std::move(task));
  }
  wake_.notify_one();
}

void WorkerPool::parallelFor(int64_t count, const std::function<void(int64_t)>& body) {
  if (count <= 0) return;
  auto loop = std::make_shared<Loop>();
  loop->count = count;
  loop->body = &body;
  const int64_t helpers = std::min<int64_t>(threads_ - 1, count - 1);
  for (int64_t i = 0; i < helpers; ++i) submit([loop] { loop->run(); });
  loop->run();
  std::unique_lock lock(loop->mutex);
  loop->done.wait(lock, [&] { return loop->finished == loop->count; });
  if (loop->failure) std::rethrow_exception(loop->failure);
}

void WorkerPool::work() {
  for (;;) {
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !queue_.empty(); });
      if (queue_.empty()) return;
      task = std::move(queue_.front());
      queue_.pop_front();
    }
    task();
  }
}

}  // namespace sluice
