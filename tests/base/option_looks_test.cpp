// Surfaces and labels as options say them.
#include <gtest/gtest.h>

#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"

namespace sluice {
namespace {

TEST(SurfaceLook, isAValueWithAnOpacityAndAColour) {
  EXPECT_EQ(parseSurfaceLook("300"), (SurfaceLook{300, 1, ""}));
  EXPECT_EQ(parseSurfaceLook("-1.5e2:0.4"), (SurfaceLook{-150, 0.4, ""}));
  EXPECT_EQ(parseSurfaceLook("0:1:ff8800"), (SurfaceLook{0, 1, "ff8800"}));
  for (const char* wrong : {"", "x", "1:", "1:2", "1:-0.1", "1:0.5:", "1:0.5:a b", "1:0.5:a:b",
                            "nan", "inf", "1,2", "1:green"})
    EXPECT_FALSE(parseSurfaceLook(wrong)) << wrong;
  for (const char* text : {"300", "-150:0.4", "0:1:ff8800"})
    EXPECT_EQ(surfaceLookText(*parseSurfaceLook(text)), text);
}

TEST(LabelLook, isOfOneLabelOfSeveralOrOfAll) {
  EXPECT_EQ(parseLabelLook("3=ff8800"), (LabelLook{3, 3, "ff8800", {}}));
  EXPECT_EQ(parseLabelLook("3=ff8800:0.4"), (LabelLook{3, 3, "ff8800", 0.4}));
  EXPECT_EQ(parseLabelLook("-2--1=:0"), (LabelLook{-2, -1, "", 0.0}));
  EXPECT_EQ(parseLabelLook("all=:0"), (LabelLook{.opacity = 0.0}));
  for (const char* wrong : {"", "3", "3=", "=red", "3=red:", "3=red:2", "7-3=red", "3=:x", "3=r d",
                            "1.7=red", "0.5-3=red"})
    EXPECT_FALSE(parseLabelLook(wrong)) << wrong;
  for (const char* text : {"3=ff8800", "3=ff8800:0.4", "-2--1=:0", "all=:0", "3-7=green"})
    EXPECT_EQ(labelLookText(*parseLabelLook(text)), text);
}

}  // namespace
}  // namespace sluice
