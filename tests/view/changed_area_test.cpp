#include "src/view/state/screen/changed_area.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace sluice {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

constexpr int kSide = 48;
const ScreenArea kAll{0, 0, kSide, kSide};

// A list of rectangles, as two triangles each.
struct Rectangle {
  ScreenArea place;
  uint32_t color = 0;
  uint64_t texture = 1;
  ScreenArea clip = kAll;
};

DrawnList listOf(const std::vector<Rectangle>& rectangles, const std::string& name = "list") {
  DrawnList list;
  list.name = name;
  for (const Rectangle& each : rectangles) {
    const auto first = static_cast<uint32_t>(list.vertices.size());
    const auto& [left, top, right, bottom] = each.place;
    for (const auto& [x, y] : {std::pair(left, top), {right, top}, {right, bottom}, {left, bottom}})
      list.vertices.push_back({x, y, 0, 0, each.color});
    list.commands.push_back({each.clip, each.texture, list.indices.size(), 6, 0});
    for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) list.indices.push_back(first + corner);
  }
  return list;
}

TEST(ChangedArea, isNothingOfTheSameFrame) {
  const DrawnList list = listOf({{{0, 0, 9, 9}, 1}, {{5, 5, 20, 20}, 2}});
  EXPECT_TRUE(changedArea(list, list).isEmpty());
  EXPECT_TRUE(changedArea({}, {}).isEmpty());
  EXPECT_THAT(changedAreas(std::vector{list}, std::vector{list}, {}, kAll), IsEmpty());
}

TEST(ChangedArea, holdsWhereSomethingWasAndWhereItIs) {
  const auto with = [](float x) {
    return listOf({{{0, 0, 48, 48}, 1}, {{x, 4, x + 6, 8}, 2}, {{40, 40, 44, 44}, 3}});
  };
  EXPECT_EQ(changedArea(with(10), with(20)), (ScreenArea{10, 4, 26, 8}));
}

TEST(ChangedArea, holdsAllOfATriangleOfWhichOneCornerMoved) {
  EXPECT_EQ(changedArea(listOf({{{2, 2, 10, 6}, 1}}), listOf({{{2, 2, 12, 6}, 1}})),
            (ScreenArea{2, 2, 12, 6}));
}

TEST(ChangedArea, endsWhereItIsClipped) {
  const ScreenArea clip{0, 0, 15, 15};
  EXPECT_EQ(changedArea(listOf({{{10, 10, 30, 30}, 1, 1, clip}}),
                        listOf({{{10, 10, 30, 30}, 2, 1, clip}})),
            (ScreenArea{10, 10, 15, 15}));
}

TEST(ChangedArea, holdsWhatShowsATextureThatIsAnother) {
  const DrawnList list =
      listOf({{{0, 0, 9, 9}, 1, 1}, {{10, 10, 20, 20}, 1, 7}, {{30, 30, 40, 40}, 1}});
  EXPECT_EQ(changedArea(list, list, std::vector<uint64_t>{7}), (ScreenArea{10, 10, 20, 20}));
  EXPECT_TRUE(changedArea(list, list, std::vector<uint64_t>{8}).isEmpty());
}

TEST(ChangedArea, isAllWhereListsCameOrWent) {
  const DrawnList a = listOf({{{0, 0, 4, 4}, 1}}, "a"), b = listOf({{{8, 8, 9, 9}, 1}}, "b");
  EXPECT_THAT(changedAreas(std::vector{a}, std::vector{a, b}, {}, kAll), ElementsAre(kAll));
  EXPECT_THAT(changedAreas(std::vector{a, b}, std::vector{b, a}, {}, kAll), ElementsAre(kAll));
}

TEST(ChangedArea, keepsTheAreasOfTwoListsApart) {
  const auto lists = [](uint32_t color) {
    return std::vector{listOf({{{0, 0, 4, 4}, color}}, "a"), listOf({{{8, 8, 9, 9}, color}}, "b")};
  };
  EXPECT_THAT(changedAreas(lists(1), lists(2), {}, kAll),
              UnorderedElementsAre(ScreenArea{0, 0, 4, 4}, ScreenArea{8, 8, 9, 9}));
}

TEST(ChangedArea, joinsThoseThatMeet) {
  // The hull of the first two meets the third, which met neither.
  EXPECT_THAT(apart({{0, 0, 4, 4}, {3, 3, 10, 10}, {8, 0, 9, 1}, {20, 20, 21, 21}}),
              UnorderedElementsAre(ScreenArea{0, 0, 10, 10}, ScreenArea{20, 20, 21, 21}));
  EXPECT_THAT(apart({{0, 0, 4, 4}, {4, 0, 8, 4}}), SizeIs(2)) << "half-open";
}

// Pixels of a painter that knows nothing of areas: the last rectangle that covers one wins.
std::vector<uint32_t> painted(const std::vector<Rectangle>& rectangles) {
  std::vector<uint32_t> pixels(size_t{kSide} * kSide, 0);
  for (const Rectangle& each : rectangles) {
    const ScreenArea area = common(each.place, each.clip);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const float at_x = static_cast<float>(x) + 0.5F, at_y = static_cast<float>(y) + 0.5F;
        if (at_x >= area.left && at_x < area.right && at_y >= area.top && at_y < area.bottom)
          pixels[static_cast<size_t>(y * kSide + x)] = each.color;
      }
  }
  return pixels;
}

TEST(ChangedArea, holdsEveryPixelThatDiffers) {
  std::mt19937 random(3);
  const auto number = [&](int below) {
    return static_cast<int>(random() % static_cast<unsigned>(below));
  };
  const auto rectangle = [&] {
    const auto left = static_cast<float>(number(40)), top = static_cast<float>(number(40));
    const ScreenArea clip{static_cast<float>(number(8)), static_cast<float>(number(8)), 44, 46};
    return Rectangle{{left, top, left + static_cast<float>(1 + number(12)),
                      top + static_cast<float>(1 + number(12))},
                     static_cast<uint32_t>(random() | 1U),
                     1,
                     clip};
  };
  size_t unchanged = 0;
  for (int round = 0; round < 400; ++round) {
    std::vector<Rectangle> last;
    for (int i = number(9); i >= 0; --i) last.push_back(rectangle());
    std::vector<Rectangle> now = last;
    for (int edits = number(3); edits > 0; --edits) {
      const auto at = now.begin() + number(static_cast<int>(now.size()) + 1);
      if (number(2) == 0 || at == now.end()) {
        now.insert(at, rectangle());
      } else if (number(2) == 0) {
        now.erase(at);
      } else {
        at->color ^= 2U;
      }
      if (now.empty()) now.push_back(rectangle());
    }
    const ScreenArea area = changedArea(listOf(last), listOf(now));
    const auto before = painted(last), after = painted(now);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto i = static_cast<size_t>(y * kSide + x);
        if (before[i] == after[i]) continue;
        const float at_x = static_cast<float>(x), at_y = static_cast<float>(y);
        ASSERT_TRUE(at_x >= area.left && at_x < area.right && at_y >= area.top &&
                    at_y < area.bottom)
            << "round " << round << ", pixel " << x << ", " << y;
      }
    unchanged += area.isEmpty() ? 1 : 0;
  }
  EXPECT_GT(unchanged, 50U);
}

}  // namespace
}  // namespace sluice
