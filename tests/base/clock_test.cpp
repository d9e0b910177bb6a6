#include "src/base/clock.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <memory>

namespace sluice {
namespace {

TEST(Stopwatch, lapsAddUpToTheWhole) {
  const Stopwatch whole;
  Stopwatch laps;
  double sum = 0;
  for (int i = 0; i < 100; ++i) {
    const double lap = laps.lap();
    EXPECT_GE(lap, 0);
    sum += lap;
  }
  EXPECT_LE(sum, whole.seconds());
}

TEST(Process, peakCoversMemoryThatWasTouched) {
  constexpr size_t kBytes = size_t{64} << 20;
  const auto bytes = std::make_unique_for_overwrite<char[]>(kBytes);
  std::memset(bytes.get(), 1, kBytes);
  EXPECT_GE(peakResidentBytes(), kBytes);
  EXPECT_EQ(bytes[kBytes / 2], 1);
}

TEST(Process, availableMemoryIsNoMoreThanTheMachineHas) {
  const uint64_t all = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<uint64_t>(sysconf(_SC_PAGE_SIZE));
  EXPECT_LE(availableMemoryBytes(), all);
  EXPECT_GT(availableMemoryBytes(), 0U);
}

}  // namespace
}  // namespace sluice
