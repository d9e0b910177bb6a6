// Boxes of channels that are drawn together: which join, and in which order.
#include "src/cpu/added_boxes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sluice {
namespace {

// A box for each letter, in this order.
std::vector<BoxDraw> boxesOf(const std::string& letters) {
  std::vector<BoxDraw> boxes;
  for (const char letter : letters) {
    BoxDraw box;
    box.cells = {{letter, 0, 0}, {letter + 1, 1, 1}};
    boxes.push_back(box);
  }
  return boxes;
}

// The boxes as letters with the number of their channel, and those that join behind a sign.
std::string joined(const std::vector<std::string>& channels) {
  std::vector<std::vector<BoxDraw>> boxes;
  for (const std::string& letters : channels) boxes.push_back(boxesOf(letters));
  std::string text;
  for (const BoxDraw& box : joinAlike(boxes)) {
    text += box.joins ? "+" : " ";
    text += static_cast<char>(box.cells.lo[0]);
    text += std::to_string(box.channel);
  }
  return text;
}

TEST(AddedBoxes, ofTheSameCellsJoin) {
  EXPECT_EQ(joined({"abc", "abc"}), " a0+a1 b0+b1 c0+c1");
  EXPECT_EQ(joined({"abc", "b", "ac"}), " a0+a2 b0+b1 c0+c2");
}

TEST(AddedBoxes, keepTheOrderOfTheirChannel) {
  EXPECT_EQ(joined({"ab", "ba"}), " b1 a0+a1 b0");
  EXPECT_EQ(joined({"a", "xay"}), " x1 a0+a1 y1");
}

TEST(AddedBoxes, mayBeMissingInAChannel) {
  EXPECT_EQ(joined({"", "ab", ""}), " a1 b1");
  EXPECT_EQ(joined({"ab", ""}), " a0 b0");
}

}  // namespace
}  // namespace sluice
