#include "tests/cache/policies/naive_policies.h"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include "cache/policies/random.h"

namespace sluice::test {
namespace {

class NaiveLru : public NaivePolicy {
 public:
  using NaivePolicy::NaivePolicy;

 protected:
  void hit(Key key) override {
    order_.remove(key);
    order_.push_front(key);
  }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) evict(Key{*oldest(order_)});
    order_.push_front(key);
  }
  void removed(Key key) override { order_.remove(key); }
  std::list<Key> order_;
};

class NaiveFifo final : public NaiveLru {
 public:
  using NaiveLru::NaiveLru;
  void hit(Key) override {}
};

// A real ring with a hand, as opposed to ClockPolicy's queue.
class NaiveClock final : public NaivePolicy {
 public:
  using NaivePolicy::NaivePolicy;

 private:
  void hit(Key key) override { referenced_.insert(key); }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      if (pinned_.contains(ring_[hand_])) {
        // Pinned ones keep their place relative to the hand: look past them without moving it.
        size_t look = hand_;
        while (pinned_.contains(ring_[look])) look = (look + 1) % ring_.size();
        visit(look);
      } else {
        visit(hand_);
      }
    }
    ring_.insert(ring_.begin() + static_cast<std::ptrdiff_t>(hand_), key);
    hand_ = (hand_ + 1) % ring_.size();
  }
  // The hand is at `at` or only pinned entries lie between.
  void visit(size_t at) {
    const Key key = ring_[at];
    if (!referenced_.contains(key)) return evict(key);
    referenced_.erase(key);
    // Passed: it is now the last that the hand comes to.
    ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(at));
    if (at < hand_) --hand_;
    ring_.insert(ring_.begin() + static_cast<std::ptrdiff_t>(hand_), key);
    hand_ = (hand_ + 1) % ring_.size();
  }
  void removed(Key key) override {
    const auto at = std::find(ring_.begin(), ring_.end(), key);
    if (static_cast<size_t>(at - ring_.begin()) < hand_) --hand_;
    ring_.erase(at);
    referenced_.erase(key);
    if (hand_ >= ring_.size()) hand_ = 0;
  }
  std::vector<Key> ring_;  // the hand goes up
  size_t hand_ = 0;
  std::set<Key> referenced_;
};

class NaiveRandom final : public NaivePolicy {
 public:
  NaiveRandom(uint64_t capacity, uint64_t seed) : NaivePolicy(capacity), random_(seed) {}

 private:
  void hit(Key) override {}
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      size_t i = random_.below(slots_.size());
      while (pinned_.contains(slots_[i])) i = (i + 1) % slots_.size();
      evict(slots_[i]);
    }
    slots_.push_back(key);
  }
  void removed(Key key) override {
    std::swap(*std::find(slots_.begin(), slots_.end(), key), slots_.back());
    slots_.pop_back();
  }
  Random random_;
  std::vector<Key> slots_;
};

class NaiveSrrip final : public NaivePolicy {
 public:
  using NaivePolicy::NaivePolicy;

 private:
  // A single list, newest state first; predictions rise one by one.
  void hit(Key key) override {
    states_.remove_if([&](const auto& s) { return s.first == key; });
    states_.push_front({key, 0});
  }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      const auto victim = std::find_if(states_.rbegin(), states_.rend(), [&](const auto& s) {
        return s.second == 3 && !pinned_.contains(s.first);
      });
      if (victim != states_.rend()) {
        evict(Key{victim->first});
        continue;
      }
      // Entries that were at 3 already have been in that state longest: they go behind the rest.
      std::list<std::pair<Key, int>> stay;
      for (auto i = states_.begin(); i != states_.end();) {
        if (i->second == 3) {
          stay.push_back(*i);
          i = states_.erase(i);
        } else {
          ++i->second;
          ++i;
        }
      }
      states_.splice(states_.end(), stay);
    }
    states_.push_front({key, 2});
  }
  void removed(Key key) override {
    states_.remove_if([&](const auto& s) { return s.first == key; });
  }
  std::list<std::pair<Key, int>> states_;
};

class NaiveSieve final : public NaivePolicy {
 public:
  using NaivePolicy::NaivePolicy;

 private:
  void hit(Key key) override { visited_.insert(key); }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      if (!hand_) hand_ = queue_.back();
      const Key at = *hand_;
      if (!pinned_.contains(at) && !visited_.contains(at)) {
        evict(at);  // removed() moves the hand on
      } else {
        if (!pinned_.contains(at)) visited_.erase(at);
        moveOn();
      }
    }
    queue_.push_front(key);
  }
  void moveOn() {
    const auto i = std::find(queue_.begin(), queue_.end(), *hand_);
    if (i == queue_.begin()) {
      hand_.reset();
    } else {
      hand_ = *std::prev(i);
    }
  }
  void removed(Key key) override {
    if (hand_ == key) moveOn();
    queue_.remove(key);
    visited_.erase(key);
  }
  std::list<Key> queue_;
  std::optional<Key> hand_;
  std::set<Key> visited_;
};

class NaiveBelady final : public NaivePolicy {
 public:
  NaiveBelady(uint64_t capacity, std::vector<uint32_t> next_uses)
      : NaivePolicy(capacity), next_uses_(std::move(next_uses)) {}

 private:
  void hit(Key key) override { next_[key] = next_uses_[requests_ - 1]; }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      std::optional<std::pair<uint32_t, Key>> furthest;
      for (const auto& [k, w] : weights_) {
        if (pinned_.contains(k)) continue;
        const std::pair<uint32_t, Key> use{next_.at(k), k};
        if (!furthest || use > *furthest) furthest = use;
      }
      evict(furthest->second);
    }
    next_[key] = next_uses_[requests_ - 1];
  }
  void removed(Key) override {}
  const std::vector<uint32_t> next_uses_;
  std::map<Key, uint32_t> next_;
};

}  // namespace

std::unique_ptr<NaivePolicy> makeNaivePolicy(PolicyKind kind, uint64_t capacity, uint64_t seed,
                                             const std::vector<uint32_t>& next_uses) {
  switch (kind) {
    case PolicyKind::kLru:
      return std::make_unique<NaiveLru>(capacity);
    case PolicyKind::kFifo:
      return std::make_unique<NaiveFifo>(capacity);
    case PolicyKind::kClock:
      return std::make_unique<NaiveClock>(capacity);
    case PolicyKind::kRandom:
      return std::make_unique<NaiveRandom>(capacity, seed);
    case PolicyKind::kSrrip:
      return std::make_unique<NaiveSrrip>(capacity);
    case PolicyKind::kSieve:
      return std::make_unique<NaiveSieve>(capacity);
    case PolicyKind::kTwoQ:
    case PolicyKind::kArc:
    case PolicyKind::kS3Fifo:
      return makeNaiveGhostPolicy(kind, capacity);
    case PolicyKind::kLfu:
    case PolicyKind::kSlru:
    case PolicyKind::kWTinyLfu:
    case PolicyKind::kLirs:
    case PolicyKind::kGdsf:
      return makeNaiveCountingPolicy(kind, capacity);
    case PolicyKind::kBelady:
      return std::make_unique<NaiveBelady>(capacity, next_uses);
    case PolicyKind::kBeladyPages:
      break;  // held against kBelady and all others in simulator_test.cpp
  }
  std::abort();
}

}  // namespace sluice::test
