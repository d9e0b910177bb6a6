#include "src/base/files/numbered_name.h"

#include <gtest/gtest.h>

#include "io/files/file_list.h"
#include "src/base/error.h"

namespace sluice {
namespace {

TEST(NumberedName, hashesAndPercentsTakeTheNumber) {
  EXPECT_EQ(numberedName("d/t_####.png", 7, true), "d/t_0007.png");
  EXPECT_EQ(numberedName("t_####.png", 12345, false), "t_12345.png");
  EXPECT_EQ(numberedName("#.png", 3, false), "3.png");
  EXPECT_EQ(numberedName("t_%04d.png", 7, true), "t_0007.png");
  EXPECT_EQ(numberedName("t_%4d.png", 7, true), "t_0007.png");
  EXPECT_EQ(numberedName("t_%d.png", 7, false), "t_7.png");
  EXPECT_EQ(numberedName("50%%_%02u.png", 7, false), "50%_07.png") << "as names to read";
}

TEST(NumberedName, withoutAPlaceTheNumberGoesBeforeTheExtensionOrNowhere) {
  EXPECT_EQ(numberedName("d/turn.png", 7, true), "d/turn_007.png");
  EXPECT_EQ(numberedName("d/turn.png", 7, false), "d/turn.png");
  EXPECT_EQ(numberedName("a%b/turn.png", 7, false), "a%b/turn.png") << "folders are as they are";
  EXPECT_FALSE(isNumbered("a%b/turn.png"));
  EXPECT_TRUE(isNumbered("turn_##.png"));
}

TEST(NumberedName, otherPatternsAreRefused) {
  for (const char* name : {"%s.png", "%d%d.png", "%999d.png", "%.png", "%-1d.png", "##_#.png",
                           "#%d.png", "%4D.png", "100%.png"})
    EXPECT_THROW(numberedName(name, 1, true), Error) << name;
}

TEST(NumberedName, extensionsAreComparedInLowerCase) {
  EXPECT_EQ(lowerExtension("A.PNG"), ".png");
  EXPECT_EQ(lowerExtension("a"), "");
}

}  // namespace
}  // namespace sluice
