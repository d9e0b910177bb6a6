// The naive policies that remember, as ghosts, keys that they evicted: 2Q, ARC and S3-FIFO.
#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "tests/cache/policies/naive_policies.h"

namespace sluice::test {
namespace {

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
    const auto c = static_cast<double>(capacity_);
    const auto b1 = static_cast<double>(b1_.weight()), b2 = static_cast<double>(b2_.weight());
    if (b1_.contains(key)) {
      p_ = std::min(p_ + weight * (b1 >= b2 ? 1 : b2 / b1), c);
      b1_.take(key);
      while (full(weight)) replace(false);
      t2_.entries.push_front({key, weight});
    } else if (b2_.contains(key)) {
      p_ = std::max(p_ - weight * (b2 >= b1 ? 1 : b1 / b2), 0.0);
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
    const auto t1 = static_cast<double>(t1_.weight());
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
  double p_ = 0;
};

class NaiveS3Fifo final : public NaiveGhostPolicy {
 public:
  using NaiveGhostPolicy::NaiveGhostPolicy;

 private:
  void hit(Key key) override { count_[key] = std::min(3, count_[key] + 1); }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      const bool takes_small = 10 * small_.weight() >= capacity_ || oldestOf(main_) == nullptr;
      if (takes_small && oldestOf(small_) != nullptr) {
        evictFromSmall();
      } else {
        evictFromMain();
      }
    }
    count_[key] = 0;
    (ghost_.take(key) ? main_ : small_).entries.push_front({key, weight});
  }
  bool overMains(const GhostList& list) const { return 10 * list.weight() > 9 * capacity_; }
  void evictFromSmall() {
    while (const Key* small = oldestOf(small_)) {
      const std::pair<Key, uint32_t> entry{*small, weightOf(*small)};
      if (count_[entry.first] <= 1) {
        evict(entry.first);
        ghost_.entries.push_front(entry);
        while (overMains(ghost_)) ghost_.dropOldest();
        return;
      }
      small_.take(entry.first);
      count_[entry.first] = 0;
      main_.entries.push_front(entry);
      if (overMains(main_)) evictFromMain();
    }
  }
  void evictFromMain() {
    while (const Key* main = oldestOf(main_)) {
      const std::pair<Key, uint32_t> entry{*main, weightOf(*main)};
      if (count_[entry.first] == 0) {
        evict(entry.first);
        return;
      }
      --count_[entry.first];
      main_.take(entry.first);
      main_.entries.push_front(entry);
    }
  }
  void removed(Key key) override {
    small_.take(key);
    main_.take(key);
  }
  void forgetGhost(Key key) override { ghost_.take(key); }
  GhostList small_, main_, ghost_;
  std::map<Key, int> count_;
};

}  // namespace

std::unique_ptr<NaivePolicy> makeNaiveGhostPolicy(PolicyKind kind, uint64_t capacity) {
  if (kind == PolicyKind::kTwoQ) return std::make_unique<NaiveTwoQ>(capacity);
  if (kind == PolicyKind::kArc) return std::make_unique<NaiveArc>(capacity);
  SLUICE_CHECK(kind == PolicyKind::kS3Fifo);
  return std::make_unique<NaiveS3Fifo>(capacity);
}

}  // namespace sluice::test
