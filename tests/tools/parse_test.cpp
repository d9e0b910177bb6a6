#include "tools/command_line/parse.h"

#include <gtest/gtest.h>

#include "cache/trace/trace.h"
#include "tools/bench/bench.h"

namespace sluice {
namespace {

TEST(Parse, takesExactlyTheNumbersAskedFor) {
  EXPECT_EQ(parseNumbers("1,2.5,-3", 3), (std::vector<double>{1, 2.5, -3}));
  EXPECT_EQ(parseNumbers("64x32x32", 3), (std::vector<double>{64, 32, 32}));
  for (const char* bad :
       {"", "1,2", "1,2,3,4", "1,,3", "1,2,3,", "a,b,c", "1,2,nan", "1,2,inf", "1 2 3"})
    EXPECT_FALSE(parseNumbers(bad, 3)) << bad;
}

TEST(Parse, pictureSizesAreWholeAndPositive) {
  const auto size = parsePictureSize("640x480");
  ASSERT_TRUE(size);
  EXPECT_EQ(size->width, 640);
  EXPECT_EQ(size->height, 480);
  EXPECT_EQ(parsePictureSize("300")->height, 300);
  for (const char* bad : {"0x5", "-1x5", "1.5x2", "3000000000x5", "x", "5x"})
    EXPECT_FALSE(parsePictureSize(bad)) << bad;
}

TEST(Parse, colorsAreSixHexDigits) {
  const auto color = parseColor("#ff8000");
  ASSERT_TRUE(color);
  EXPECT_FLOAT_EQ((*color)[0], 1);
  EXPECT_FLOAT_EQ((*color)[1], 128.0F / 255);
  EXPECT_FLOAT_EQ((*color)[2], 0);
  for (const char* bad : {"fff", "gg0000", "1234567", "", "#12345"})
    EXPECT_FALSE(parseColor(bad)) << bad;
}

TEST(Parse, aThresholdMayFollowTheFile) {
  using Split = std::pair<std::string, std::optional<double>>;
  EXPECT_EQ(splitThreshold("a.nii@40", 3.0), (Split{"a.nii", 40.0}));
  EXPECT_EQ(splitThreshold("a.nii", 3.0), (Split{"a.nii", 3.0}));
  EXPECT_EQ(splitThreshold("me@home.nii", std::nullopt), (Split{"me@home.nii", std::nullopt}));
}

TEST(Parse, theNameOfATraceSaysItsFormat) {
  EXPECT_EQ(traceFormatOf("t.txt"), TraceFormat::kText);
  EXPECT_EQ(traceFormatOf("t.csv"), TraceFormat::kCsv);
  EXPECT_EQ(traceFormatOf("t.oracleGeneral"), TraceFormat::kOracleGeneral);
  EXPECT_EQ(traceFormatOf("t.din"), TraceFormat::kDin);
  EXPECT_EQ(traceFormatOf("t.trace"), TraceFormat::kBinary);
}

}  // namespace
}  // namespace sluice
