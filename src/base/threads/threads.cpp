#include "src/base/threads/threads.h"

#include <algorithm>
#include <latch>
#include <new>
#include <system_error>

#include "src/base/threads/kept_addresses.h"

namespace sluice {
namespace {

// A driver's libraries, its buffers, and the allocator's arenas.
constexpr size_t kKeptBytes = size_t{512} << 20;

}  // namespace

std::thread startThread(const std::function<void()>& body) {
  return std::thread(body);
}

std::vector<std::thread> startThreads(int count, const std::function<void()>& body,
                                      const ThreadStarter& start) {
  const KeptAddresses kept(kKeptBytes);
  // Somebody has taken of them already: one goes on with the work.
  if (!kept.areThere()) count = std::min(count, 1);
  std::vector<std::thread> threads;
  try {
    while (static_cast<int>(threads.size()) < count) {
      threads.emplace_back();  // before there is a thread that it could lose
      threads.back() = start(body);
    }
    return threads;
  } catch (const std::system_error&) {
  } catch (const std::bad_alloc&) {
  }
  if (!threads.empty() && !threads.back().joinable()) threads.pop_back();
  return threads;
}

int startableThreads(int most) {
  std::latch end(1);
  std::vector<std::thread> threads = startThreads(most, [&end] { end.wait(); });
  end.count_down();
  for (std::thread& thread : threads) thread.join();
  return static_cast<int>(threads.size());
}

int processorCount() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace sluice
