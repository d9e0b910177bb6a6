#include "src/view/state/screen/input_queue.h"

namespace sluice {
namespace {

using Kind = InputEvent::Kind;

// Whether a frame that has taken `last` can take `next`, too.
bool joins(const InputEvent& last, const InputEvent& next) {
  switch (next.kind) {
    case Kind::kMove:
      // The pointer enters at the place of the movement that follows.
      return last.kind == Kind::kMove || (last.kind == Kind::kEnter && last.is_on);
    case Kind::kWheel:
      return last.kind == Kind::kWheel;
    // A key that types comes with its text, in this order.
    case Kind::kText:
      return last.kind == Kind::kText || (last.kind == Kind::kKey && last.is_on);
    default:
      return false;
  }
}

}  // namespace

std::vector<InputEvent> InputQueue::take() {
  std::vector<InputEvent> taken;
  while (!waiting_.empty() && (taken.empty() || joins(taken.back(), waiting_.front()))) {
    taken.push_back(waiting_.front());
    waiting_.pop_front();
  }
  return taken;
}

}  // namespace sluice
