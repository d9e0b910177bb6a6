#include "tools/scene/processors.h"

#include <gtest/gtest.h>

#include <cerrno>

namespace sluice {
namespace {

TEST(Processors, ofAMachineOfAnySizeAreListed) {
  constexpr size_t kProcessors = 5000;
  int asked = 0;
  const auto ask = [&](size_t bytes, cpu_set_t* set) {
    ++asked;
    if (8 * bytes < kProcessors) {
      errno = EINVAL;
      return -1;
    }
    CPU_SET_S(3, bytes, set);
    CPU_SET_S(kProcessors - 1, bytes, set);
    return 0;
  };
  EXPECT_EQ(processorsOfProcess(ask), (std::vector<int>{3, kProcessors - 1}));
  EXPECT_GT(asked, 1);
}

TEST(Processors, areNoneIfTheSystemDoesNotTell) {
  EXPECT_TRUE(processorsOfProcess([](size_t, cpu_set_t*) {
                errno = ENOSYS;
                return -1;
              }).empty());
  EXPECT_TRUE(processorsOfProcess([](size_t, cpu_set_t*) {
                errno = EINVAL;
                return -1;
              }).empty());
}

TEST(Processors, ofThisProcessAreSome) {
  EXPECT_FALSE(processorsOfProcess().empty());
}

}  // namespace
}  // namespace sluice
