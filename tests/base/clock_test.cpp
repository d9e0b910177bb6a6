#include "src/base/threads/clock.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <memory>

#include "src/base/files/descriptor.h"
#include "tests/support/temp_folder.h"

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

TEST(Process, ownMemoryIsWhatWasTouchedAndNoMappedFile) {
  constexpr size_t kBytes = size_t{64} << 20;
  const uint64_t before = anonymousBytes();
  auto bytes = std::make_unique_for_overwrite<char[]>(kBytes);
  EXPECT_LT(anonymousBytes(), before + kBytes / 2);  // addresses alone
  std::memset(bytes.get(), 1, kBytes);
  EXPECT_GE(anonymousBytes(), before + kBytes);
  EXPECT_LE(anonymousBytes(), peakResidentBytes());
  EXPECT_EQ(bytes[kBytes / 2], 1);
  bytes.reset();
  const TempFolder folder;
  const auto path = folder / "file";
  std::filesystem::resize_file(folder.write("file", "x"), kBytes);
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const uint64_t unmapped = anonymousBytes();
  void* const mapped = mmap(nullptr, kBytes, PROT_READ, MAP_SHARED | MAP_POPULATE, file.get(), 0);
  ASSERT_NE(mapped, MAP_FAILED);
  EXPECT_LT(anonymousBytes(), unmapped + kBytes / 2);
  munmap(mapped, kBytes);
}

TEST(Process, availableMemoryIsNoMoreThanTheMachineHas) {
  const uint64_t all = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                       static_cast<uint64_t>(sysconf(_SC_PAGE_SIZE));
  EXPECT_LE(availableMemoryBytes(), all);
  EXPECT_GT(availableMemoryBytes(), 0U);
}

}  // namespace
}  // namespace sluice
