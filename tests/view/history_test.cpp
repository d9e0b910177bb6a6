#include "src/view/state/editing/history.h"

#include <gtest/gtest.h>

namespace sluice {
namespace {

TEST(History, undoesAndRedoesOneStepEach) {
  History<int> history(1);
  history.change(2);
  history.change(3);
  EXPECT_TRUE(history.undo());
  EXPECT_EQ(history.now(), 2);
  EXPECT_TRUE(history.redo());
  EXPECT_EQ(history.now(), 3);
  EXPECT_FALSE(history.redo());
  EXPECT_TRUE(history.undo());
  EXPECT_TRUE(history.undo());
  EXPECT_FALSE(history.undo());
  EXPECT_EQ(history.now(), 1);
}

TEST(History, undoesAGestureAtOnce) {
  History<int> history(1);
  for (int i = 2; i < 50; ++i) history.change(i, 7);
  history.change(100, 8);
  history.undo();
  EXPECT_EQ(history.now(), 49);
  history.undo();
  EXPECT_EQ(history.now(), 1);
}

TEST(History, aChangeAfterAnUndoForgetsWhatWasUndone) {
  History<int> history(1);
  history.change(2, 3);
  history.undo();
  history.change(5, 3);
  EXPECT_FALSE(history.canRedo());
  history.undo();
  EXPECT_EQ(history.now(), 1);
}

TEST(History, noChangeIsNoStep) {
  History<int> history(1);
  history.change(1);
  EXPECT_FALSE(history.canUndo());
}

TEST(History, keepsABoundedNumberOfSteps) {
  History<int> history(0);
  const int steps = static_cast<int>(History<int>::kMost) + 100;
  for (int i = 1; i <= steps; ++i) history.change(i);
  int undone = 0;
  while (history.undo()) ++undone;
  EXPECT_EQ(undone, static_cast<int>(History<int>::kMost));
  EXPECT_EQ(history.now(), 100);
}

}  // namespace
}  // namespace sluice
