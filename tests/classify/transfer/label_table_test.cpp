// Tables of labels as ITK-SNAP and 3D Slicer write them, and the looks of single labels.
#include "src/classify/transfer/label_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "src/classify/transfer/automatic_look.h"
#include "src/classify/transfer/opacity_table.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

TEST(LabelTable, readsLabelDescriptionsOfItkSnap) {
  const auto table = parseLabelTable(
      "################################\n"
      "# ITK-SnAP Label Description File\n"
      "    0     0    0    0        0  0  0    \"Clear Label\"\n"
      "    2     0  255   51      0.4  1  1    \"left \"lung\"\"\r\n"
      "    1   255    0    0        1  0  1    \"hidden\"\n",
      "t.txt");
  ASSERT_EQ(table.size(), 3U);
  EXPECT_EQ(table[0], (LabelStyle{0, {0, 0, 0}, 0, "Clear Label"}));
  EXPECT_EQ(table[1], (LabelStyle{1, {1, 0, 0}, 0, "hidden"}));
  EXPECT_EQ(table[2], (LabelStyle{2, {0, 1, 0.2}, 0.4, "left \"lung\""}));
}

TEST(LabelTable, readsColourTablesOf3dSlicer) {
  const auto table = parseLabelTable(
      "# Color table file /tmp/x.ctbl\n"
      "# 3 values\n"
      "0 Background 0 0 0 0\n"
      "1 left_lung 255 51 0 255\n"
      "300 vessel 0 0 255 51",
      "t.ctbl");
  ASSERT_EQ(table.size(), 3U);
  EXPECT_EQ(table[0].opacity, 0);
  EXPECT_EQ(table[1], (LabelStyle{1, {1, 0.2, 0}, 1, "left lung"}));
  EXPECT_EQ(table[2], (LabelStyle{300, {0, 0, 1}, 0.2, "vessel"}));
}

TEST(LabelTable, opacitiesThatAreAllZeroAreOpaqueAsInFreeSurfers) {
  const auto table = parseLabelTable(
      "0   Unknown                                 0   0   0   0\n"
      "2   Left-Cerebral-White-Matter              245 245 245 0\n",
      "FreeSurferColorLUT.txt");
  EXPECT_EQ(table[0].opacity, 0);
  EXPECT_EQ(table[1].opacity, 1);
  EXPECT_EQ(table[1].name, "Left-Cerebral-White-Matter");
}

TEST(LabelTable, mayBeginWithAByteOrderMark) {
  const auto table = parseLabelTable(
      "\xef\xbb\xbf"
      "1 255.0 0 1 0.5 1 1 \"x\"\n",
      "t.txt");
  ASSERT_EQ(table.size(), 1U);
  EXPECT_EQ(table[0], (LabelStyle{1, {1, 0, 1 / 255.0}, 0.5, "x"}));
}

TEST(LabelTable, saysWhichLineIsWrong) {
  const auto errorOfText = [](const char* text) {
    return errorOf([&] { parseLabelTable(text, "t.txt"); });
  };
  EXPECT_THAT(errorOfText("# only\n\n"), HasSubstr("t.txt: expected NUMBER R G B"));
  EXPECT_THAT(errorOfText("1 a 0 0 0 255\n2 b 0 0 256 255\n"),
              HasSubstr("t.txt: line 2: expected NUMBER R G B A"));
  EXPECT_THAT(errorOfText("1 0 0 0 2 1 1 \"x\"\n"), HasSubstr("line 1"));
  EXPECT_THAT(errorOfText("1 a 0 0 0 255 7\n"), HasSubstr("line 1"));
  EXPECT_THAT(errorOfText("one\n"), HasSubstr("found one"));
  // Fractions of 1 in place of 0 to 255, and numbers that are no labels.
  for (const char* line :
       {"1 left 1.0 0 0 1.0\n", "1 a 255 0 0 0.5\n", "1 0.5 0 0 1 1 1 \"left\"\n",
        "1.5 255 0 0 1 1 1 \"x\"\n", "1e20 255 0 0 1 1 1 \"x\"\n"})
    EXPECT_THAT(errorOfText(line), HasSubstr("whole numbers for the label")) << line;
  EXPECT_THAT(errorOfText("1 a 0 0 0 255\n1 b 0 0 0 255\n"),
              HasSubstr("t.txt: label 1 is there twice"));
}

TEST(LabelTable, labelsThatATableDoesNotNameDoNotShow) {
  auto styles = labelStyles({0, 1, 2, 3}, 0);
  applyTable(styles, {{1, {1, 0, 0}, 0.5, "one"}, {3, {0, 1, 0}, 1, "three"}, {9}});
  EXPECT_EQ(styles[1].name, "one");
  EXPECT_EQ(styles[1].opacity, 0.5);
  EXPECT_EQ(styles[2].opacity, 0);
  EXPECT_EQ(styles[3].rgb, (Vec3d{0, 1, 0}));
}

TEST(LabelTable, looksChangeTheirLabelsOneAfterAnother) {
  auto styles = labelStyles({0, 1, 2, 3, 7}, 0);
  const Vec3d own = styles[3].rgb;
  std::vector<LabelLook> looks;
  for (const char* text : {"all=:0.1", "2-3=:0.5", "3-7=ff0000", "7=:1"})
    looks.push_back(*parseLabelLook(text));
  applyLooks(styles, looks);
  EXPECT_EQ(styles[0].opacity, 0) << "the background";
  EXPECT_EQ(styles[1].opacity, 0.1);
  EXPECT_EQ(styles[2].opacity, 0.5);
  EXPECT_EQ(styles[3].opacity, 0.5);
  EXPECT_EQ(styles[3].rgb, (Vec3d{1, 0, 0}));
  EXPECT_NE(own, styles[3].rgb);
  EXPECT_EQ(styles[4].opacity, 1);
  EXPECT_THAT(errorOf([&] { applyLooks(styles, {*parseLabelLook("1=nocolour")}); }),
              HasSubstr("--label 1=nocolour: there is no colour nocolour; give RRGGBB or one of"));
}

TEST(LabelTable, everyOfManyLabelsHasItsOwnEntry) {
  std::vector<LabelStyle> styles;
  for (int i = 0; i < 65536; ++i)
    styles.push_back(
        {static_cast<double>(i), {i % 256 / 255.0, i / 256 / 255.0, 0}, i % 3 == 0 ? 0.0 : 0.5});
  const OpacityTable table(labelsTransfer(styles), {DeviceType::kU16, 1, 0}, {0, 65535});
  ASSERT_EQ(table.entries(), 65536);
  EXPECT_FALSE(table.mustInterpolate());
  for (int i = 0; i < 65536; ++i) {
    const auto at = static_cast<size_t>(i);
    ASSERT_EQ(table.opacity()[at], i % 3 == 0 ? 0.0F : 0.5F) << i;
    ASSERT_EQ(table.rgba()[4 * at + 1], static_cast<float>(i / 256 / 255.0)) << i;
    ASSERT_EQ(table.shown().anyIn(i, i), i % 3 != 0) << i;
  }
}

TEST(LabelTable, labelsFarApartHaveTheirOwnEntries) {
  for (const double greatest : {65536.0, 70000.0, 1048575.0}) {
    SCOPED_TRACE(greatest);
    const auto styles = labelStyles({0, 1, 17, greatest}, 0);
    EXPECT_EQ(labelsTooClose(styles), 0U);
    const OpacityTable table(labelsTransfer(styles), {DeviceType::kF32, 1, 0}, {0, greatest});
    for (const LabelStyle& style : styles) {
      const auto entry = static_cast<size_t>(table.entryOf(style.label));
      EXPECT_EQ(table.opacity()[entry], style.opacity) << style.label;
      EXPECT_EQ(table.rgba()[4 * entry], static_cast<float>(style.rgb.x)) << style.label;
    }
    EXPECT_FALSE(table.shown().anyIn(0, 0)) << "the background";
  }
  EXPECT_EQ(labelsTooClose(labelStyles({0, 1, 17, 2000000, 614454277}, 0)), 3U);
  EXPECT_EQ(labelsTooClose(labelStyles({0, 1, 17, 2000000}, 0)), 2U);
}

TEST(LabelTable, ofMoreLabelsThanAreCountedEachIsThere) {
  ValueCounts counts;
  for (int i = 0; i < 4096; ++i) counts.entries.push_back({16.0 * i, 16.0 * i + 15, 100});
  const auto styles = labelStylesOf(counts);
  ASSERT_EQ(styles.size(), 65536U);
  EXPECT_EQ(styles[0].opacity, 0);
  EXPECT_EQ(styles[65535].label, 65535);
  counts.entries.push_back({65536, 65537, 1});
  EXPECT_THAT(errorOf([&] { labelStylesOf(counts); }), HasSubstr("expected at most 65536 of them"));
}

}  // namespace
}  // namespace sluice
