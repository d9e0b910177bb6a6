#include "src/base/values/bytes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sluice {
namespace {

TEST(ParseBytes, unitsArePowersOf1024) {
  EXPECT_EQ(parseBytes("0"), 0U);
  EXPECT_EQ(parseBytes("17"), 17U);
  EXPECT_EQ(parseBytes("17B"), 17U);
  EXPECT_EQ(parseBytes("3K"), 3072U);
  EXPECT_EQ(parseBytes("512M"), 536870912U);
  EXPECT_EQ(parseBytes("2G"), 2147483648U);
  EXPECT_EQ(parseBytes("5T"), 5497558138880U);
}

TEST(ParseBytes, caseAndSuffixesDoNotMatter) {
  for (const char* text : {"4k", "4K", "4KB", "4kb", "4Kb", "4KiB", "4kib", "4KIB"})
    EXPECT_EQ(parseBytes(text), 4096U) << text;
}

TEST(ParseBytes, takesDecimalNumbers) {
  EXPECT_EQ(parseBytes("1.5G"), 1610612736U);
  EXPECT_EQ(parseBytes("0.5K"), 512U);
  EXPECT_EQ(parseBytes("1e3"), 1000U);
}

TEST(ParseBytes, wholeNumbersAreExactUpToTheLimit) {
  EXPECT_EQ(parseBytes("9007199254740993"), 9007199254740993U);  // 2^53 + 1, not a double
  EXPECT_EQ(parseBytes("9223372036854775807"), 9223372036854775807U);
  EXPECT_EQ(parseBytes("9223372036854775808"), std::nullopt);
  EXPECT_EQ(parseBytes("8388607T"), 8388607U * (uint64_t{1} << 40));
  EXPECT_EQ(parseBytes("8388608T"), std::nullopt);
  EXPECT_EQ(parseBytes("8388608.0T"), std::nullopt);
  EXPECT_EQ(parseBytes("99999999999999999999999"), std::nullopt);
}

TEST(ParseBytes, refusesWhatIsNoSize) {
  for (const char* text : {"", " ", "K", "-1", "-0", "1 K", " 1", "1K ", "1KK", "1X", "1iB", "1BB",
                           "1KiBs", "0x10", "nan", "inf", "1,5G", "1e400"})
    EXPECT_EQ(parseBytes(text), std::nullopt) << '"' << text << '"';
}

TEST(FormatBytes, smallNumbersAreWhole) {
  EXPECT_EQ(formatBytes(0), "0 B");
  EXPECT_EQ(formatBytes(1023), "1023 B");
  EXPECT_EQ(formatBytes(1024), "1.0 KiB");
}

TEST(FormatBytes, neverPrintsAThousandOfAUnitThatHasANext) {
  EXPECT_EQ(formatBytes((uint64_t{1} << 20) - 1), "1.0 MiB");
  EXPECT_EQ(formatBytes(1023 * 1024), "1023.0 KiB");
  EXPECT_EQ(formatBytes(UINT64_MAX), "16.0 EiB");
}

TEST(FormatBytes, isWithinItsOneDecimal) {
  for (uint64_t bytes = 1024; bytes < uint64_t{1} << 60; bytes = bytes * 7 / 3 + 1) {
    const std::string text = formatBytes(bytes);
    const auto space = text.find(' ');
    ASSERT_NE(space, std::string::npos);
    const int power = static_cast<int>(std::string("BKMGTPE").find(text[space + 1]));
    EXPECT_NEAR(std::stod(text), std::ldexp(static_cast<double>(bytes), -10 * power), 0.0501)
        << text;
  }
}

}  // namespace
}  // namespace sluice
