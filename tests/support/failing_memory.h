// FailingMemory: while one lives, an allocation of its thread fails, to see that nothing is left
// half done when memory runs out.
//
// Replaces operator new of the whole test program. A thread may have one at a time.
#pragma once

#include <cstdint>

namespace sluice {

class FailingMemory {
 public:
  // Allocation `nth` from now, counted from 0, and all after it throw std::bad_alloc.
  explicit FailingMemory(int64_t nth);
  ~FailingMemory();
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;

  // Whether there were as many allocations.
  bool failed() const;
};

// Calls f(n) for n = 0, 1, ... until a call in which no allocation failed: f makes a FailingMemory
// of n around the tested code and returns its failed().
template <class F>
void forEachAllocation(F&& f) {
  for (int64_t n = 0; f(n); ++n) {
  }
}

}  // namespace sluice
