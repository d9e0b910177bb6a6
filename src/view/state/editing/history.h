// History: the states that a view was in, for undo and redo. Plain values; one thread.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace sluice {

// Changes of one gesture (a drag, a wheel's turns) carry one number above 0 and are undone
// together; those with 0 stand for themselves.
template <class State>
class History {
 public:
  static constexpr size_t kMost = 256;

  explicit History(State first = {}) : now_(std::move(first)) {}

  const State& now() const { return now_; }
  bool canUndo() const { return !past_.empty(); }
  bool canRedo() const { return !future_.empty(); }

  // A state equal to the one that is makes no step.
  void change(State next, int gesture = 0) {
    if (next == now_) return;
    const bool joins = gesture != 0 && gesture == gesture_ && !past_.empty();
    if (!joins) past_.push_back(std::move(now_));
    if (past_.size() > kMost) past_.erase(past_.begin());
    now_ = std::move(next);
    future_.clear();
    gesture_ = gesture;
  }
  // For changes that are no step of their own: a time that plays, a cross hair.
  void replace(State next) { now_ = std::move(next); }
  // False if there is none.
  bool undo() { return move(past_, future_); }
  bool redo() { return move(future_, past_); }

 private:
  bool move(std::vector<State>& from, std::vector<State>& to) {
    if (from.empty()) return false;
    to.push_back(std::move(now_));
    now_ = std::move(from.back());
    from.pop_back();
    gesture_ = 0;
    return true;
  }

  State now_;
  std::vector<State> past_, future_;  // the nearest last
  int gesture_ = 0;
};

}  // namespace sluice
