// Large pages are a hint that changes no value and takes no more memory than is used.
#include "src/base/memory/large_pages.h"

#include <gtest/gtest.h>

#include <sys/mman.h>

#include <array>

namespace sluice {
namespace {

constexpr size_t kLarge = size_t{2} << 20;

// Whether the kernel notes the wish for the mapping of `at`: "hg" among its flags.
bool wantsLargePages(const std::byte* at) {
  std::FILE* maps = std::fopen("/proc/self/smaps", "r");
  std::array<char, 1024> line{};
  bool inside = false, wants = false;
  while (std::fgets(line.data(), line.size(), maps) != nullptr) {
    unsigned long long from = 0, to = 0;
    if (std::sscanf(line.data(), "%llx-%llx ", &from, &to) == 2)
      inside = reinterpret_cast<uintptr_t>(at) >= from && reinterpret_cast<uintptr_t>(at) < to;
    const std::string_view text(line.data());
    if (inside && text.starts_with("VmFlags:")) wants = text.find(" hg") != std::string_view::npos;
  }
  std::fclose(maps);
  return wants;
}

class Mapping {
 public:
  explicit Mapping(size_t bytes) : bytes_(bytes) {
    begin_ = static_cast<std::byte*>(
        mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  }
  ~Mapping() { munmap(begin_, bytes_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  // The first place that a large page may start at, one of them on either side.
  std::byte* page() const {
    const auto at = reinterpret_cast<uintptr_t>(begin_);
    return begin_ + ((at + 2 * kLarge - 1) / kLarge * kLarge - at);
  }

 private:
  std::byte* begin_;
  size_t bytes_;
};

TEST(LargePages, areWishedForWhereAWholeOneFits) {
  if (std::FILE* known = std::fopen("/sys/kernel/mm/transparent_hugepage/enabled", "r")) {
    std::fclose(known);
  } else {
    GTEST_SKIP() << "this kernel has no /sys/kernel/mm/transparent_hugepage";
  }
  const Mapping mapping(6 * kLarge);
  std::byte* const page = mapping.page();
  preferLargePages({page + 1, kLarge - 1});  // ends with the page, starts inside it
  preferLargePages({page - 4096, kLarge});   // ends inside it
  EXPECT_FALSE(wantsLargePages(page));
  preferLargePages({page - 1, kLarge + 2});
  EXPECT_TRUE(wantsLargePages(page));
  EXPECT_FALSE(wantsLargePages(page - 1)) << "what is outside may belong to others";
  EXPECT_FALSE(wantsLargePages(page + kLarge));
}

TEST(LargePages, aReservedVectorKeepsItsValues) {
  std::vector<int64_t> values = {1, 2, 3};
  reserveLarge(values, kLarge);
  EXPECT_GE(values.capacity(), kLarge);
  values.resize(kLarge, 7);
  EXPECT_EQ(values[2], 3);
  EXPECT_EQ(values[kLarge - 1], 7);
  std::vector<int64_t> none;
  reserveLarge(none, 0);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace sluice
