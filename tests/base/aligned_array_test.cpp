#include "src/base/memory/aligned_array.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace sluice {
namespace {

TEST(AlignedArray, beginsAtALineOfTheCaches) {
  for (const size_t count : {size_t{1}, size_t{1000}, size_t{1} << 20, size_t{5} << 20}) {
    const AlignedArray<float> array = alignedForOverwrite<float>(count);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(array.get()) % 64, 0U) << count;
    array[0] = array[count - 1] = 1;
  }
}

}  // namespace
}  // namespace sluice
