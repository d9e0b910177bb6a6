#include "src/base/error.h"

#include <gtest/gtest.h>

#include <cerrno>

namespace sluice {
namespace {

struct Unprintable {
  int value;
  friend bool operator==(const Unprintable&, const Unprintable&) = default;
};

TEST(Error, failFormatsOneLine) {
  try {
    fail("{}: expected {} bytes, found {}", "volume.raw", 10, 7);
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "volume.raw: expected 10 bytes, found 7");
  }
}

TEST(Error, failErrnoEndsWithTheReason) {
  try {
    failErrno("volume.raw: cannot be opened", ENOENT);
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "volume.raw: cannot be opened: No such file or directory");
  }
}

TEST(Check, passesWhatHolds) {
  int evaluated = 0;
  SLUICE_CHECK(++evaluated == 1);
  SLUICE_CHECK_EQ(++evaluated, 2);
  SLUICE_CHECK_LE(2, 2);
  SLUICE_CHECK_LT(1, 2);
  EXPECT_EQ(evaluated, 2);  // each argument once
}

TEST(CheckDeathTest, namesTheConditionAndThePlace) {
  const int blocks = 3;
  EXPECT_DEATH(SLUICE_CHECK(blocks == 4), "error_test.cpp:[0-9]+: check failed: blocks == 4");
}

TEST(CheckDeathTest, printsBothValues) {
  const int blocks = 3;
  EXPECT_DEATH(SLUICE_CHECK_EQ(blocks, 4), "blocks == 4 3 against 4");
  EXPECT_DEATH(SLUICE_CHECK_LE(blocks, 2), "blocks <= 2 3 against 2");
  EXPECT_DEATH(SLUICE_CHECK_LT(blocks, 3), "blocks < 3 3 against 3");
}

TEST(CheckDeathTest, saysSoWhenValuesDoNotPrint) {
  const Unprintable a{1}, b{2};
  EXPECT_DEATH(SLUICE_CHECK_EQ(a, b), "a == b values that do not print");
}

}  // namespace
}  // namespace sluice
