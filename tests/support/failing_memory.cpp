#include "tests/support/failing_memory.h"

#include <cstdlib>
#include <new>

namespace {

constexpr int64_t kNever = -1;
thread_local int64_t left = kNever;  // allocations that succeed

}  // namespace

void* operator new(size_t bytes) {
  if (left == 0) throw std::bad_alloc();
  if (left > 0) --left;
  if (void* const memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc();
}
// A sanitizer has one of its own otherwise, whose memory is none of malloc's.
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}

namespace sluice {

FailingMemory::FailingMemory(int64_t nth) {
  left = nth;
}
FailingMemory::~FailingMemory() {
  left = kNever;
}
bool FailingMemory::failed() const {
  return left == 0;
}

}  // namespace sluice
