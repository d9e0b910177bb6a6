// StopToken: tells work that takes a while that it is no longer wanted.
//
// Whoever may lose interest (a window, a handler of signals, a caller's other thread) keeps a
// StopSource and passes its token down; loops ask between two steps, and unwind through their
// destructors by throwing Interrupted. Tokens are small values; asking is one load. Any thread.
#pragma once

#include <atomic>
#include <exception>
#include <memory>
#include <utility>

namespace sluice {

// Thrown when stopped work ends. Nothing is wrong; there is just no result.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

class StopToken {
 public:
  // Is never asked to stop.
  StopToken() = default;
  // Stops once `flag` is true. Requires: it outlives the token and its copies.
  explicit StopToken(const std::atomic<bool>& flag)
      : flag_(std::shared_ptr<const std::atomic<bool>>(), &flag) {}

  bool isStopRequested() const {
    return flag_ != nullptr && flag_->load(std::memory_order_relaxed);
  }
  // Throws Interrupted.
  void throwIfStopped() const {
    if (isStopRequested()) throw Interrupted();
  }

 private:
  friend class StopSource;
  explicit StopToken(std::shared_ptr<const std::atomic<bool>> flag) : flag_(std::move(flag)) {}

  std::shared_ptr<const std::atomic<bool>> flag_;
};

class StopSource {
 public:
  void requestStop() { *flag_ = true; }
  StopToken token() const { return StopToken(flag_); }

 private:
  std::shared_ptr<std::atomic<bool>> flag_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace sluice
