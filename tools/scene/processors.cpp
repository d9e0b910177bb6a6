#include "tools/scene/processors.h"

#include <cerrno>
#include <memory>

namespace sluice {
namespace {

struct FreeSet {
  void operator()(cpu_set_t* set) const { CPU_FREE(set); }
};

}  // namespace

int askSystem(size_t bytes, cpu_set_t* set) {
  return sched_getaffinity(0, bytes, set);
}

std::vector<int> processorsOfProcess(const AskProcessors& ask) {
  // Linux is built for at most 8192 processors today; the limit only ends the search.
  constexpr int kMostProcessors = 1 << 20;
  // The system refuses a set that is too small, and does not tell the size that it wants.
  for (int count = CPU_SETSIZE; count <= kMostProcessors; count *= 2) {
    const std::unique_ptr<cpu_set_t, FreeSet> set(CPU_ALLOC(static_cast<size_t>(count)));
    if (set == nullptr) return {};
    const size_t bytes = CPU_ALLOC_SIZE(static_cast<size_t>(count));
    CPU_ZERO_S(bytes, set.get());
    if (ask(bytes, set.get()) == 0) {
      std::vector<int> numbers;
      for (int i = 0; i < count; ++i)
        if (CPU_ISSET_S(static_cast<size_t>(i), bytes, set.get())) numbers.push_back(i);
      return numbers;
    }
    if (errno != EINVAL) return {};
  }
  return {};
}

}  // namespace sluice
