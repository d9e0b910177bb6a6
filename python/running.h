// Calls of the library from Python: without the interpreter's lock, so that other threads of Python
// go on, and ended by Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>
#include <sluice/error.h>
#include <sluice/progress.h>
#include <unistd.h>

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>

namespace sluice::python {

namespace py = pybind11;

// The function of Python behind a ProgressFunction: called with the stage's name, the work done and
// the total. None: nobody is told.
ProgressFunction progressFunction(const py::object& told);

// A function of Python that threads of the library call, and may let go of.
std::shared_ptr<py::function> sharedFunction(py::function function);

// Runs `call` with a stop token on a thread of its own, without the interpreter's lock, and waits
// for it; a signal whose handler raises (KeyboardInterrupt) stops it. Throws what `call` throws, or
// the handler's exception once the call has ended. Requires: the lock is held.
void runWatched(const std::function<void(const std::stop_token&)>& call);

// The same of a call with a result.
template <class Call>
auto run(const Call& call) {
  std::optional<decltype(call(std::stop_token()))> result;
  runWatched([&](const std::stop_token& stop) { result.emplace(call(stop)); });
  return std::move(*result);
}

// An object of the library that is released without the interpreter's lock, since its threads may
// be waiting for it. In a process that was forked off its threads are missing: there it is neither
// used nor released.
template <class T>
class Held {
 public:
  explicit Held(T object) : object_(std::make_unique<T>(std::move(object))) {}
  Held(Held&&) noexcept = default;
  Held& operator=(Held&&) = delete;
  ~Held() {
    if (object_ == nullptr) return;
    if (getpid() != process_) {
      static_cast<void>(object_.release());
    } else {
      const py::gil_scoped_release unlocked;
      object_.reset();
    }
  }

  // Throws Error in a process that was forked off.
  T& get() const {
    if (getpid() != process_)
      throw Error(
          "this volume was opened before the process was forked, and its threads are missing here: "
          "open it again, or start processes with multiprocessing's method 'spawn'",
          Error::Kind::kRequest);
    return *object_;
  }

 private:
  std::unique_ptr<T> object_;
  pid_t process_ = getpid();
};

}  // namespace sluice::python
