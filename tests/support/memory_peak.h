// MemoryPeak: the most bytes of the heap that a thread has taken since it was made, counted at
// malloc, so that a C library's are seen too.
//
// Replaces malloc of the whole test program; counts nothing under a sanitizer, which has its own.
#pragma once

#include <cstdint>

namespace sluice {

class MemoryPeak {
 public:
  MemoryPeak();
  ~MemoryPeak();
  MemoryPeak(const MemoryPeak&) = delete;
  MemoryPeak& operator=(const MemoryPeak&) = delete;

  static bool works();
  int64_t bytes() const;
};

}  // namespace sluice
