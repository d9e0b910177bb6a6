#include "tests/support/memory_peak.h"

#include <malloc.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>

namespace {

thread_local bool counting = false;
thread_local int64_t now = 0, most = 0;

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
namespace {

void* counted(void* memory) {
  if (counting && memory != nullptr)
    most = std::max(most, now += static_cast<int64_t>(malloc_usable_size(memory)));
  return memory;
}
void uncount(void* memory) {
  if (counting && memory != nullptr) now -= static_cast<int64_t>(malloc_usable_size(memory));
}

}  // namespace

extern "C" {
void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t count, size_t bytes);
void* __libc_realloc(void* memory, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);
void __libc_free(void* memory);

void* malloc(size_t bytes) {
  return counted(__libc_malloc(bytes));
}
void* calloc(size_t count, size_t bytes) {
  return counted(__libc_calloc(count, bytes));
}
void* realloc(void* memory, size_t bytes) {
  uncount(memory);
  return counted(__libc_realloc(memory, bytes));
}
int posix_memalign(void** memory, size_t alignment, size_t bytes) {
  *memory = counted(__libc_memalign(alignment, bytes));
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) {
  uncount(memory);
  __libc_free(memory);
}
}

bool sluice::MemoryPeak::works() {
  return true;
}
#else
bool sluice::MemoryPeak::works() {
  return false;
}
#endif

namespace sluice {

MemoryPeak::MemoryPeak() {
  now = most = 0;
  counting = true;
}
MemoryPeak::~MemoryPeak() {
  counting = false;
}
int64_t MemoryPeak::bytes() const {
  return most;
}

}  // namespace sluice
