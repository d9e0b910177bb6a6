// Stopwatch: seconds on the steady clock. Process: what the system says of this process's memory
// and processor time.
#pragma once

#include <chrono>
#include <cstdint>

namespace sluice {

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  // Seconds since construction or the last lap.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double taken = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return taken;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Of all its threads, since it began.
double processorSeconds();

// Peak resident bytes of this process, mapped files included.
uint64_t peakResidentBytes();
// What of the resident bytes is this process's own and no file's: what --memory is about. Pages of
// files that are read or mapped, a driver's libraries too, are the system's to take back. 0 where
// the system does not say.
uint64_t anonymousBytes();
// What this process may use: the machine's memory or its cgroup's limit, whichever is smaller.
uint64_t availableMemoryBytes();

}  // namespace sluice
