#include "src/base/files/byte_stream.h"

#include <gtest/gtest.h>

#include <limits>

namespace sluice {
namespace {

TEST(ByteStream, givesBackWhatWasWritten) {
  ByteWriter out;
  out.value(int32_t{-7});
  out.list(std::vector<double>{0.5, -3});
  out.list(std::vector<uint8_t>{});
  out.value(uint8_t{9});
  EXPECT_EQ(out.bytes.size(), 4 + (8 + 2 * 8) + 8 + 1U);
  ByteReader in(out.bytes);
  int32_t number = 0;
  std::vector<double> list;
  std::vector<uint8_t> empty{1};
  uint8_t last = 0;
  EXPECT_TRUE(in.value(number) && in.list(list) && in.list(empty) && in.value(last));
  EXPECT_EQ(number, -7);
  EXPECT_EQ(list, (std::vector<double>{0.5, -3}));
  EXPECT_TRUE(empty.empty());
  EXPECT_EQ(last, 9);
  EXPECT_TRUE(in.left().empty());
}

TEST(ByteStream, endsWhereTheBytesDo) {
  ByteWriter out;
  out.list(std::vector<double>{1, 2, 3});
  for (size_t size = 0; size < out.bytes.size(); ++size) {
    ByteReader in(std::span(out.bytes).first(size));
    std::vector<double> list;
    EXPECT_FALSE(in.list(list)) << size;
  }
}

TEST(ByteStream, aLengthBeyondTheBytesTakesNoMemory) {
  for (const uint64_t count : {uint64_t{3}, std::numeric_limits<uint64_t>::max()}) {
    ByteWriter out;
    out.value(count);
    out.value(uint64_t{0});
    ByteReader in(out.bytes);
    std::vector<uint64_t> list;
    EXPECT_FALSE(in.list(list));
    EXPECT_EQ(list.capacity(), 0U);
  }
}

}  // namespace
}  // namespace sluice
