// Planes that are transposed in squares: each number lands where plain loops put it, and nothing
// else is written.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "src/texture/transposed_copy.h"

namespace sluice {
namespace {

constexpr int64_t kRow = 53;  // numbers of a row in memory

template <class T, int kNumbers>
void expectPlainLoops(int64_t width, int64_t height, int64_t before) {
  const int64_t row = std::min(before + height + 5, kRow);
  std::vector<T> in(static_cast<size_t>(kRow * width));
  for (size_t i = 0; i < in.size(); ++i) in[i] = static_cast<T>(7 * i);
  const int64_t out_stride = kNumbers * width + 3;
  std::vector<T> out(static_cast<size_t>(out_stride * height), T{99}), expected = out;
  for (int64_t y = 0; y < height; ++y)
    for (int64_t x = 0; x < width; ++x)
      expected[static_cast<size_t>(y * out_stride + x * kNumbers)] =
          in[static_cast<size_t>(x * kRow + before + y)];
  transposedCopy<kNumbers>(TransposedPlane<T>{in.data() + before, kRow, before, row - before},
                           width, height, out_stride, out.data());
  EXPECT_EQ(out, expected) << width << " x " << height << " behind " << before;
}

template <class T>
class TransposedCopyTest : public testing::Test {};
using Types = testing::Types<uint8_t, uint16_t, float>;
TYPED_TEST_SUITE(TransposedCopyTest, Types);

TYPED_TEST(TransposedCopyTest, putsEachNumberWherePlainLoopsDo) {
  for (const int64_t width : {1, 3, 4, 7, 8, 15, 16, 17, 33, 40})
    for (const int64_t height : {1, 2, 4, 5, 9, 16, 17, 31, 40})
      for (const int64_t before : {0, 1, 6, 13}) {
        expectPlainLoops<TypeParam, 1>(width, height, before);
        expectPlainLoops<TypeParam, 2>(width, height, before);
      }
}

}  // namespace
}  // namespace sluice
