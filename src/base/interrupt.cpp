#include "src/base/interrupt.h"

#include <csignal>

namespace sluice {
namespace {

// A signal handler can reach nothing else: the one piece of static state in the program.
volatile std::sig_atomic_t interrupted = 0;

void handle(int signal_number) {
  interrupted = 1;
  std::signal(signal_number, SIG_DFL);
}

}  // namespace

void watchForInterruption() {
  std::signal(SIGINT, handle);
  std::signal(SIGTERM, handle);
}

void throwIfInterrupted() {
  if (interrupted != 0) throw Interrupted();
}

}  // namespace sluice
