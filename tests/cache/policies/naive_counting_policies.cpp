// The naive policies that look at how often or how closely entries were requested: LFU, GDSF, SLRU,
// W-TinyLFU and LIRS.
#include <algorithm>
#include <tuple>

#include "src/base/error.h"
#include "tests/cache/policies/naive_policies.h"

namespace sluice::test {
namespace {

// LFU and GDSF: every resident's priority is looked at for each victim.
class NaivePriority final : public NaivePolicy {
 public:
  NaivePriority(uint64_t capacity, bool is_gdsf) : NaivePolicy(capacity), is_gdsf_(is_gdsf) {}

 private:
  struct Known {
    int times = 0;
    double priority = 0;
    uint64_t last = 0;
  };
  void touched(Key key, uint32_t weight) {
    Known& k = known_[key];
    ++k.times;
    k.priority = is_gdsf_ ? l_ + static_cast<double>(k.times) / weight : k.times;
    k.last = requests_;
  }
  void hit(Key key) override { touched(key, weights_.at(key)); }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      const Key* lowest = nullptr;
      for (const auto& [k, known] : known_)
        if (!pinned_.contains(k) &&
            (lowest == nullptr || std::tie(known.priority, known.last) <
                                      std::tie(known_[*lowest].priority, known_[*lowest].last)))
          lowest = &k;
      l_ = known_.at(*lowest).priority;
      evict(Key{*lowest});
    }
    touched(key, weight);
  }
  void removed(Key key) override { known_.erase(key); }

  const bool is_gdsf_;
  double l_ = 0;
  std::map<Key, Known> known_;  // resident keys
};

class NaiveSlru : public NaivePolicy {
 public:
  NaiveSlru(uint64_t capacity, uint64_t pages) : NaivePolicy(capacity), most_(pages * 4 / 5) {}
  explicit NaiveSlru(uint64_t capacity) : NaiveSlru(capacity, capacity) {}

 protected:
  uint64_t weightOf(const std::list<Key>& list) const {
    uint64_t sum = 0;
    for (const Key k : list) sum += weights_.at(k);
    return sum;
  }
  static bool contains(const std::list<Key>& list, Key key) {
    return std::find(list.begin(), list.end(), key) != list.end();
  }
  void hit(Key key) override {
    probation_.remove(key);
    protected_.remove(key);
    protected_.push_front(key);
    while (weightOf(protected_) > most_) {
      probation_.push_front(protected_.back());
      protected_.pop_back();
    }
  }
  const Key* victim() const {
    const Key* of_probation = oldest(probation_);
    return of_probation != nullptr ? of_probation : oldest(protected_);
  }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) evict(Key{*victim()});
    probation_.push_front(key);
  }
  void removed(Key key) override {
    probation_.remove(key);
    protected_.remove(key);
  }

  const uint64_t most_;  // pages of protected_
  std::list<Key> probation_, protected_;
};

class NaiveWTinyLfu final : public NaiveSlru {
 public:
  explicit NaiveWTinyLfu(uint64_t capacity)
      : NaiveSlru(capacity, capacity - std::max<uint64_t>(1, capacity / 100)),
        share_(std::max<uint64_t>(1, capacity / 100)) {}

 private:
  // All counts halve at once, that of the requests too, as the paper has it.
  void count(Key key) {
    times_[key] = std::min(15, times_[key] + 1);
    if (++counted_ < 10 * capacity_) return;
    counted_ /= 2;
    for (auto& [k, times] : times_) times /= 2;
  }
  void hit(Key key) override {
    count(key);
    if (!contains(window_, key)) return NaiveSlru::hit(key);
    window_.remove(key);
    window_.push_front(key);
  }
  void miss(Key key, uint32_t weight) override {
    count(key);
    while (full(weight)) {
      const Key* candidate = oldest(window_);
      const Key* of_main = victim();
      if (of_main == nullptr) {
        evict(Key{*candidate});
      } else if (candidate == nullptr || weightOf(window_) + weight <= share_) {
        evict(Key{*of_main});
      } else {
        const Key winner = *candidate, loser = *of_main;
        if (times_[winner] > times_[loser]) {
          evict(loser);
          window_.remove(winner);
          probation_.push_front(winner);
        } else {
          evict(winner);
        }
      }
    }
    while (!window_.empty() && weightOf(window_) + weight > share_) {
      probation_.push_front(window_.back());
      window_.pop_back();
    }
    window_.push_front(key);
  }
  void removed(Key key) override {
    window_.remove(key);
    NaiveSlru::removed(key);
  }

  const uint64_t share_;
  uint64_t counted_ = 0;
  std::map<Key, int> times_;
  std::list<Key> window_;
};

class NaiveLirs final : public NaivePolicy {
 public:
  explicit NaiveLirs(uint64_t capacity)
      : NaivePolicy(capacity), most_(capacity - std::max<uint64_t>(1, capacity / 100)) {}

 private:
  bool isLir(Key key) const { return lir_.contains(key); }
  bool inStack(Key key) const {
    return std::find(stack_.begin(), stack_.end(), key) != stack_.end();
  }
  uint64_t lirWeight() const {
    uint64_t sum = 0;
    for (const Key k : lir_) sum += weights_.contains(k) ? weights_.at(k) : new_weight_;
    return sum;
  }
  void toTop(Key key) {
    stack_.remove(key);
    stack_.push_front(key);
  }
  void prune() {
    while (!stack_.empty() && !isLir(stack_.back())) {
      ghosts_.remove_if([&](const auto& g) { return g.first == stack_.back(); });
      stack_.pop_back();
    }
  }
  void demote() {
    while (lirWeight() > most_) {
      const Key lowest = stack_.back();
      stack_.pop_back();
      lir_.erase(lowest);
      queue_.push_front(lowest);
      prune();
    }
    prune();
  }
  void hit(Key key) override {
    const bool was_in = inStack(key);
    toTop(key);
    if (!isLir(key)) {
      queue_.remove(key);
      if (was_in)
        lir_.insert(key);
      else
        queue_.push_front(key);
    }
    prune();
    demote();
  }
  void miss(Key key, uint32_t weight) override {
    while (full(weight)) {
      if (const Key* from_queue = oldest(queue_)) {
        const std::pair<Key, uint32_t> gone{*from_queue, weights_.at(*from_queue)};
        const bool stays = inStack(gone.first);
        keeps_place_ = true;
        evict(gone.first);
        keeps_place_ = false;
        if (!stays) continue;
        ghosts_.push_front(gone);
        trimGhosts();
      } else {
        evict(Key{*oldest(stackOfLir())});
      }
    }
    const bool remembered =
        std::any_of(ghosts_.begin(), ghosts_.end(), [&](const auto& g) { return g.first == key; });
    forgetGhost(key);
    new_weight_ = weight;
    if (remembered || lirWeight() + weight <= most_)
      lir_.insert(key);
    else
      queue_.push_front(key);
    stack_.push_front(key);
    demote();
  }
  void trimGhosts() {
    uint64_t sum = 0;
    for (const auto& g : ghosts_) sum += g.second;
    for (; sum > 2 * capacity_; sum -= ghosts_.back().second, ghosts_.pop_back())
      stack_.remove(ghosts_.back().first);
  }
  const std::list<Key>& stackOfLir() {
    lir_stack_.clear();
    for (const Key k : stack_)
      if (isLir(k)) lir_stack_.push_back(k);
    return lir_stack_;
  }
  void removed(Key key) override {
    queue_.remove(key);
    lir_.erase(key);
    if (!keeps_place_) stack_.remove(key);
    if (!keeps_place_) prune();
  }
  void forgetGhost(Key key) override {
    const auto gone = ghosts_.remove_if([&](const auto& g) { return g.first == key; });
    if (gone > 0) stack_.remove(key);
  }

  const uint64_t most_;                         // pages of LIR entries
  std::list<Key> stack_, queue_, lir_stack_;    // front is newest
  std::list<std::pair<Key, uint32_t>> ghosts_;  // front is newest
  std::set<Key> lir_;
  uint32_t new_weight_ = 0;   // weight of the entry that is coming in
  bool keeps_place_ = false;  // evicted entries stay in the stack as ghosts
};

}  // namespace

std::unique_ptr<NaivePolicy> makeNaiveCountingPolicy(PolicyKind kind, uint64_t capacity) {
  if (kind == PolicyKind::kLfu) return std::make_unique<NaivePriority>(capacity, false);
  if (kind == PolicyKind::kGdsf) return std::make_unique<NaivePriority>(capacity, true);
  if (kind == PolicyKind::kSlru) return std::make_unique<NaiveSlru>(capacity);
  if (kind == PolicyKind::kWTinyLfu) return std::make_unique<NaiveWTinyLfu>(capacity);
  SLUICE_CHECK(kind == PolicyKind::kLirs);
  return std::make_unique<NaiveLirs>(capacity);
}

}  // namespace sluice::test
