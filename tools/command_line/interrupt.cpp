#include "tools/command_line/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <ctime>

#include "src/base/files/temporary_name.h"

namespace sluice {
namespace {

// A signal handler can reach nothing else: the static state of the program. Any thread reads it; a
// signal handler may write lock-free atomics only.
std::atomic<bool> interrupted{false};
std::atomic<int> by_signal{0};
std::atomic<const char*> line_at_end{"interrupted"};
std::atomic<timer_t> grace{};
std::atomic<bool> has_grace{false};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free &&
              std::atomic<timer_t>::is_always_lock_free);

// Only async-signal-safe calls: an orderly end was given its time.
void endNow(int) {
  removeTemporaries();
  if (const char* const line = line_at_end.load()) {
    for (const char* part : {"sluice: ", line, "\n"})
      if (::write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  }
  // Destructors and atexit() handlers could wait for a lock that the interrupted thread holds.
  _exit(interruptionStatus());
}

void handle(int signal_number) {
  if (interrupted.load(std::memory_order_relaxed)) {  // the second one
    removeTemporaries();
    // The parent sees an end by this signal, not an exit status.
    std::signal(signal_number, SIG_DFL);
    std::raise(signal_number);
    return;
  }
  by_signal.store(signal_number, std::memory_order_relaxed);
  interrupted.store(true, std::memory_order_relaxed);
  constexpr itimerspec kGrace{{0, 0}, {kGraceMs / 1000, kGraceMs % 1000 * 1'000'000L}};
  if (!has_grace || timer_settime(grace, 0, &kGrace, nullptr) != 0) alarm(1);
}

// The timer of kGraceMs; without one, alarm() counts in seconds.
void prepareGrace() {
  std::signal(SIGALRM, endNow);
  // A parent may have left it blocked, which exec() keeps.
  sigset_t alarm_alone;
  sigemptyset(&alarm_alone);
  sigaddset(&alarm_alone, SIGALRM);
  pthread_sigmask(SIG_UNBLOCK, &alarm_alone, nullptr);
  timer_t made{};
  has_grace = timer_create(CLOCK_MONOTONIC, nullptr, &made) == 0;  // null: sends SIGALRM
  if (has_grace) grace = made;
}

}  // namespace

void watchForInterruption() {
  prepareGrace();
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP})
    // nohup and shells in scripts ignore signals for their children on purpose.
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

void sayWhenInterrupted(const char* line) {
  line_at_end = line;
}

const char* interruptedLine() {
  return line_at_end;
}

}  // namespace sluice
