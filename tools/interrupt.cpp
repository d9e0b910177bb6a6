#include "tools/interrupt.h"

#include <atomic>
#include <csignal>

namespace sluice {
namespace {

// A signal handler can reach nothing else: the one piece of static state in the program. Any thread
// reads it; a lock-free atomic is what a handler may write.
std::atomic<bool> interrupted{false};
std::atomic<int> by_signal{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

void handle(int signal_number) {
  by_signal.store(signal_number, std::memory_order_relaxed);
  interrupted.store(true, std::memory_order_relaxed);
  std::signal(signal_number, SIG_DFL);
}

}  // namespace

void watchForInterruption() {
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP})
    if (std::signal(signal_number, handle) == SIG_IGN) std::signal(signal_number, SIG_IGN);
}

int interruptionStatus() {
  constexpr int kSignalled = 128;
  const int signal_number = by_signal.load(std::memory_order_relaxed);
  return signal_number == 0 ? 0 : kSignalled + signal_number;
}

StopToken interruption() {
  return StopToken(interrupted);
}

}  // namespace sluice
