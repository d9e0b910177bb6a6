#include "src/view/state/screen/input_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace sluice {
namespace {

using Kind = InputEvent::Kind;

// One letter for each event, a blank between frames: m movement, b and B button up and down, k and
// K key up and down, w wheel, t text, e and E leave and enter, f and F focus lost and gained.
std::string framesOf(const std::string& events) {
  const auto eventOf = [](char letter) -> InputEvent {
    const bool is_on = letter >= 'A' && letter <= 'Z';
    switch (letter) {
      case 'b':
      case 'B':
        return {.kind = Kind::kButton, .is_on = is_on};
      case 'k':
      case 'K':
        return {.kind = Kind::kKey, .is_on = is_on};
      case 'w':
        return {.kind = Kind::kWheel};
      case 't':
        return {.kind = Kind::kText};
      case 'e':
      case 'E':
        return {.kind = Kind::kEnter, .is_on = is_on};
      case 'f':
      case 'F':
        return {.kind = Kind::kFocus, .is_on = is_on};
      default:
        return {.kind = Kind::kMove};
    }
  };
  InputQueue queue;
  for (const char letter : events) queue.add(eventOf(letter));
  std::string frames;
  for (size_t at = 0; !queue.isEmpty();) {
    const size_t count = queue.take().size();
    frames += (frames.empty() ? "" : " ") + events.substr(at, count);
    at += count;
  }
  return frames;
}

TEST(InputQueue, givesADragItsBeginningAndItsEnd) {
  EXPECT_EQ(framesOf("mmBmmmbmm"), "mm B mmm b mm");
}

TEST(InputQueue, givesEachClickAFrameDownAndOneUp) {
  EXPECT_EQ(framesOf("BbBb"), "B b B b");
}

TEST(InputQueue, givesEachKeyAFrameDownAndOneUp) {
  EXPECT_EQ(framesOf("KkKk"), "K k K k");
  EXPECT_EQ(framesOf("KBmbk"), "K B m b k");
}

TEST(InputQueue, keepsTextWithItsKey) {
  EXPECT_EQ(framesOf("KtkKttk"), "Kt k Ktt k");
  EXPECT_EQ(framesOf("ttK"), "tt K");
  EXPECT_EQ(framesOf("kt"), "k t");
}

TEST(InputQueue, addsUpTheWheelWhereThePointerIs) {
  EXPECT_EQ(framesOf("mwwmw"), "m ww m w");
}

TEST(InputQueue, entersWithTheMovementAndLeavesAfterIt) {
  EXPECT_EQ(framesOf("Emme"), "Emm e");
  EXPECT_EQ(framesOf("emE"), "e m E");
}

TEST(InputQueue, keepsTheOrderOfWhatALostFocusReleases) {
  EXPECT_EQ(framesOf("mfbkF"), "m f b k F");
}

TEST(InputQueue, takesMovementsAsTheyCame) {
  InputQueue queue;
  for (const double x : {1.0, 5.0, 2.0}) queue.add({.kind = Kind::kMove, .x = x, .y = -x});
  const auto taken = queue.take();
  ASSERT_EQ(taken.size(), 3U);
  EXPECT_EQ(taken[1].x, 5);
  EXPECT_EQ(taken[2].y, -2);
  EXPECT_TRUE(queue.take().empty());
}

}  // namespace
}  // namespace sluice
