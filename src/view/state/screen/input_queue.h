// InputQueue: the mouse and key events between the window system and the frames of the window.
// Plain values; one thread.
//
// A frame knows the pointer's place and the buttons and keys that are down, but no order among
// them. A slow frame finds several events waiting. If it took them all at once, a drag would begin
// where the pointer is by now, the last movement before a release would be lost, and a key that is
// up again was never down. Each frame therefore takes only events that cannot hide each other.
#pragma once

#include <deque>
#include <vector>

namespace sluice {

struct InputEvent {
  enum class Kind { kMove, kButton, kWheel, kKey, kText, kEnter, kFocus };
  Kind kind = Kind::kMove;
  int code = 0;         // button, key or character, as GLFW numbers them
  bool is_on = false;   // pressed; entered; focused
  double x = 0, y = 0;  // the place of a movement (screen units), or the steps of the wheel
};

class InputQueue {
 public:
  void add(const InputEvent& event) { waiting_.push_back(event); }
  bool isEmpty() const { return waiting_.empty(); }

  // Removes the events of the next frame and returns them in their order: movements, steps of the
  // wheel, or one other event; and the text that follows it. Empty if none waits.
  std::vector<InputEvent> take();

 private:
  std::deque<InputEvent> waiting_;
};

}  // namespace sluice
