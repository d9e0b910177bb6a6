#include "src/base/memory/large_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace sluice {

void preferLargePages(std::span<std::byte> memory) {
  constexpr uintptr_t kPage = uintptr_t{2} << 20;
  const auto begin = reinterpret_cast<uintptr_t>(memory.data());
  const uintptr_t first = (begin + kPage - 1) / kPage * kPage;
  const uintptr_t end = (begin + memory.size()) / kPage * kPage;
  if (first < end) madvise(memory.data() + (first - begin), end - first, MADV_HUGEPAGE);
}

}  // namespace sluice
