#include "tests/cache/naive_policies.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "cache/random.h"

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

// A real ring with a hand, where ClockPolicy keeps a queue.
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
  // One list, newest state first; predictions rise one by one.
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
      // What was at 3 already stays the longest in that state: it goes behind the rest.
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

// Lists by name with their keys' weights, for the policies with ghosts.
struct GhostList {
  std::list<std::pair<Key, uint32_t>> entries;  // front is newest
  uint64_t weight() const {
    uint64_t sum = 0;
    for (const auto& e : entries) sum += e.second;
    return sum;
  }
  bool take(Key key) {
    return entries.remove_if([&](const auto& e) { return e.first == key; }) > 0;
  }
  bool contains(Key key) const {
    return std::any_of(entries.begin(), entries.end(),
                       [&](const auto& e) { return e.first == key; });
  }
  void dropOldest() { entries.pop_back(); }
};

class NaiveGhostPolicy : public NaivePolicy {
 public:
  using NaivePolicy::NaivePolicy;

 protected:
  const Key* oldestOf(const GhostList& list) const {
    for (auto i = list.entries.rbegin(); i != list.entries.rend(); ++i) {
      if (!pinned_.contains(i->first)) return &i->first;
    }
    return nullptr;
  }
  uint32_t weightOf(Key key) const { return weights_.at(key); }
};

class NaiveTwoQ final : public NaiveGhostPolicy {
 public:
  using NaiveGhostPolicy::NaiveGhostPolicy;

 private:
  void hit(Key key) override {
    if (main_.take(key)) main_.entries.push_front({key, weightOf(key)});
  }
  void miss(Key key, uint32_t weight) override {
    const bool from_out = out_.take(key);
    while (full(weight)) {
      const Key* in = oldestOf(in_);
      const Key* main = oldestOf(main_);
      const uint64_t in_share = std::max<uint64_t>(1, capacity_ / 4);
      if ((in_.weight() > in_share && in != nullptr) || main == nullptr) {
        const std::pair<Key, uint32_t> gone{*in, weightOf(*in)};
        evict(gone.first);
        out_.entries.push_front(gone);
        while (out_.weight() > std::max<uint64_t>(1, capacity_ / 2)) out_.dropOldest();
      } else {
        evict(Key{*main});
      }
    }
    (from_out ? main_ : in_).entries.push_front({key, weight});
  }
  void removed(Key key) override {
    in_.take(key);
    main_.take(key);
  }
  void forgetGhost(Key key) override { out_.take(key); }
  GhostList in_, main_, out_;
};

class NaiveArc final : public NaiveGhostPolicy {
 public:
  using NaiveGhostPolicy::NaiveGhostPolicy;

 private:
  void hit(Key key) override {
    t1_.take(key);
    t2_.take(key);
    t2_.entries.push_front({key, weightOf(key)});
  }
  void miss(Key key, uint32_t weight) override {
    const auto c = static_cast<int64_t>(capacity_);
    const auto b1 = static_cast<int64_t>(b1_.weight()), b2 = static_cast<int64_t>(b2_.weight());
    if (b1_.contains(key)) {
      p_ = std::min(c, p_ + weight * std::max<int64_t>(1, b2 / std::max<int64_t>(1, b1)));
      b1_.take(key);
      while (full(weight)) replace(false);
      t2_.entries.push_front({key, weight});
    } else if (b2_.contains(key)) {
      p_ = std::max<int64_t>(0, p_ - weight * std::max<int64_t>(1, b1 / std::max<int64_t>(1, b2)));
      b2_.take(key);
      while (full(weight)) replace(true);
      t2_.entries.push_front({key, weight});
    } else {
      while (t1_.weight() + b1_.weight() + weight > capacity_) {
        if (!b1_.entries.empty()) {
          b1_.dropOldest();
        } else if (const Key* gone = oldestOf(t1_)) {
          evict(Key{*gone});
        } else {
          break;
        }
      }
      while (t1_.weight() + t2_.weight() + b1_.weight() + b2_.weight() + weight > 2 * capacity_ &&
             !b2_.entries.empty())
        b2_.dropOldest();
      while (full(weight)) replace(false);
      t1_.entries.push_front({key, weight});
    }
  }
  void replace(bool in_b2) {
    const auto t1 = static_cast<int64_t>(t1_.weight());
    const Key* one = oldestOf(t1_);
    const Key* two = oldestOf(t2_);
    const bool wants_one = t1 >= 1 && (t1 > p_ || (in_b2 && t1 == p_));
    const bool take_one = one != nullptr && (wants_one || two == nullptr);
    const Key gone = take_one ? *one : *two;
    const uint32_t weight = weightOf(gone);
    evict(gone);
    (take_one ? b1_ : b2_).entries.push_front({gone, weight});
  }
  void removed(Key key) override {
    t1_.take(key);
    t2_.take(key);
  }
  void forgetGhost(Key key) override {
    b1_.take(key);
    b2_.take(key);
  }
  GhostList t1_, t2_, b1_, b2_;
  int64_t p_ = 0;
};

class NaiveS3Fifo final : public NaiveGhostPolicy {
 public:
  using NaiveGhostPolicy::NaiveGhostPolicy;

 private:
  void hit(Key key) override { count_[key] = std::min(3, count_[key] + 1); }
  void miss(Key key, uint32_t weight) override {
    const bool remembered = ghost_.take(key);
    const uint64_t small_share = std::max<uint64_t>(1, capacity_ / 10);
    while (full(weight)) {
      const Key* small = oldestOf(small_);
      const Key* main = oldestOf(main_);
      if (small != nullptr && (small_.weight() >= small_share || main == nullptr)) {
        const std::pair<Key, uint32_t> entry{*small, weightOf(*small)};
        if (count_[entry.first] > 1) {
          small_.take(entry.first);
          count_[entry.first] = 0;
          main_.entries.push_front(entry);
        } else {
          evict(entry.first);
          ghost_.entries.push_front(entry);
          while (ghost_.weight() > std::max<uint64_t>(1, capacity_ - capacity_ / 10))
            ghost_.dropOldest();
        }
      } else {
        const std::pair<Key, uint32_t> entry{*main, weightOf(*main)};
        if (count_[entry.first] == 0) {
          evict(entry.first);
        } else {
          --count_[entry.first];
          main_.take(entry.first);
          main_.entries.push_front(entry);
        }
      }
    }
    count_[key] = 0;
    (remembered ? main_ : small_).entries.push_front({key, weight});
  }
  void removed(Key key) override {
    small_.take(key);
    main_.take(key);
  }
  void forgetGhost(Key key) override { ghost_.take(key); }
  GhostList small_, main_, ghost_;
  std::map<Key, int> count_;
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
    case PolicyKind::kTwoQ:
      return std::make_unique<NaiveTwoQ>(capacity);
    case PolicyKind::kArc:
      return std::make_unique<NaiveArc>(capacity);
    case PolicyKind::kS3Fifo:
      return std::make_unique<NaiveS3Fifo>(capacity);
    case PolicyKind::kSieve:
      return std::make_unique<NaiveSieve>(capacity);
    default:
      return std::make_unique<NaiveBelady>(capacity, next_uses);
  }
}

}  // namespace sluice::test
