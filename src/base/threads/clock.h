// Stopwatch: seconds on the steady clock. Process: this process's memory and processor time, from
// the system.
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

// Processor time of all threads of this process since it began.
double processorSeconds();

// Peak resident bytes of this process, mapped files included.
uint64_t peakResidentBytes();
// Resident bytes that belong to this process and to no file; --memory limits these. Pages of files
// that are read or mapped, including a driver's libraries, can be taken back by the system. 0 if
// the system does not tell.
uint64_t anonymousBytes();
// Memory that this process may use: the machine's memory or its cgroup's limit, whichever is
// smaller.
uint64_t availableMemoryBytes();

}  // namespace sluice
