#include "python/running.h"

#include <fmt/format.h>

#include <chrono>
#include <exception>

#include "src/base/threads/mutex.h"
#include "src/base/threads/threads.h"

namespace sluice::python {
namespace {

const char* nameOf(Progress::Stage stage) {
  switch (stage) {
    case Progress::Stage::kIndexing:
      return "indexing";
    case Progress::Stage::kDecoding:
      return "decoding";
    case Progress::Stage::kDrawing:
      break;
  }
  return "drawing";
}

// A call while it runs on its thread.
class Watched {
 public:
  void execute(const std::function<void(const std::stop_token&)>& call) {
    std::exception_ptr failure;
    try {
      call(stop_.get_token());
    } catch (...) {
      failure = std::current_exception();
    }
    const MutexLock lock(mutex_);
    failure_ = std::move(failure);
    is_done_ = true;
    changed_.notifyAll();
  }

  // Until the call has ended. Python's handlers of signals run in its main thread, when that looks.
  void wait() {
    constexpr std::chrono::milliseconds kLook{50};
    MutexLock lock(mutex_);
    while (!is_done_) {
      changed_.waitUntil(lock, std::chrono::steady_clock::now() + kLook);
      if (is_done_ || raised_) continue;
      lock.unlock();
      look();
      lock.lock();
    }
  }

  // Requires: the call has ended, and the interpreter's lock is held.
  void rethrow() {
    if (raised_) throw std::move(*raised_);
    const MutexLock lock(mutex_);
    if (failure_ != nullptr) std::rethrow_exception(failure_);
  }

 private:
  void look() {
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() == 0) return;
    raised_.emplace();
    stop_.request_stop();
  }

  std::stop_source stop_;
  std::optional<py::error_already_set> raised_;  // the waiting thread's
  Mutex mutex_;
  Condition changed_;
  bool is_done_ SLUICE_GUARDED_BY(mutex_) = false;
  std::exception_ptr failure_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace

void runWatched(const std::function<void(const std::stop_token&)>& call) {
  Watched watched;
  {
    const py::gil_scoped_release unlocked;
    const auto body = [&] { watched.execute(call); };
    auto own = startThreads(1, body);
    if (own.empty()) body();  // no thread to be had: signals wait
    watched.wait();
    for (auto& thread : own) thread.join();
  }
  watched.rethrow();
}

std::shared_ptr<py::function> sharedFunction(py::function function) {
  return {new py::function(std::move(function)), [](py::function* held) {
            const py::gil_scoped_acquire locked;
            delete held;
          }};
}

ProgressFunction progressFunction(const py::object& told) {
  if (told.is_none()) return {};
  if (!PyCallable_Check(told.ptr()))
    throw py::type_error(fmt::format("progress: expected a function, found {}",
                                     py::str(py::repr(told)).cast<std::string>()));
  return [call = sharedFunction(py::reinterpret_borrow<py::function>(told))](
             const Progress& progress) {
    const py::gil_scoped_acquire locked;
    (*call)(nameOf(progress.stage), progress.done, progress.total);
  };
}

}  // namespace sluice::python
