#include "tests/cache/policies/paper_policies.h"

#include <algorithm>
#include <list>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "src/base/error.h"

namespace sluice::test {
namespace {

// A queue whose entries are found by key: push at the head, pop at the tail, take from anywhere.
class Queue {
 public:
  size_t size() const { return order_.size(); }
  bool contains(Key key) const { return places_.contains(key); }
  void pushHead(Key key) {
    order_.push_front(key);
    places_[key] = order_.begin();
  }
  Key tail() const { return order_.back(); }
  Key popTail() {
    const Key key = order_.back();
    take(key);
    return key;
  }
  void take(Key key) {
    order_.erase(places_.at(key));
    places_.erase(key);
  }
  void moveToHead(Key key) {
    take(key);
    pushHead(key);
  }

 private:
  std::list<Key> order_;
  std::unordered_map<Key, std::list<Key>::iterator> places_;
};

class Cache {
 public:
  explicit Cache(uint64_t capacity) : c_(capacity) {}
  virtual ~Cache() = default;
  // Whether it hit.
  virtual bool request(Key x) = 0;

 protected:
  const uint64_t c_;
};

class Lru final : public Cache {
 public:
  using Cache::Cache;
  bool request(Key x) override {
    if (queue_.contains(x)) {
      queue_.moveToHead(x);
      return true;
    }
    if (queue_.size() == c_) queue_.popTail();
    queue_.pushHead(x);
    return false;
  }

 private:
  Queue queue_;
};

class Fifo final : public Cache {
 public:
  using Cache::Cache;
  bool request(Key x) override {
    if (queue_.contains(x)) return true;
    if (queue_.size() == c_) queue_.popTail();
    queue_.pushHead(x);
    return false;
  }

 private:
  Queue queue_;
};

// Corbato 1968: frames in a ring, a use bit each, a hand that clears bits until it finds none set.
class Clock final : public Cache {
 public:
  using Cache::Cache;
  bool request(Key x) override {
    const auto found = frame_of_.find(x);
    if (found != frame_of_.end()) {
      used_[found->second] = true;
      return true;
    }
    size_t frame = frames_.size();
    if (frames_.size() < c_) {
      frames_.push_back(x);
      used_.push_back(false);
    } else {
      while (used_[hand_]) {
        used_[hand_] = false;
        hand_ = (hand_ + 1) % c_;
      }
      frame = hand_;
      frame_of_.erase(frames_[frame]);
      frames_[frame] = x;
      hand_ = (hand_ + 1) % c_;
    }
    frame_of_[x] = frame;
    return false;
  }

 private:
  std::vector<Key> frames_;
  std::vector<bool> used_;
  std::unordered_map<Key, size_t> frame_of_;
  size_t hand_ = 0;
};

// Zhang 2024, algorithm 1.
class Sieve final : public Cache {
 public:
  explicit Sieve(uint64_t capacity) : Cache(capacity), hand_(queue_.end()) {}
  bool request(Key x) override {
    const auto found = objects_.find(x);
    if (found != objects_.end()) {
      found->second.visited = true;
      return true;
    }
    if (queue_.size() == c_) {
      auto o = hand_ == queue_.end() ? std::prev(queue_.end()) : hand_;
      while (objects_.at(*o).visited) {
        objects_.at(*o).visited = false;
        o = o == queue_.begin() ? std::prev(queue_.end()) : std::prev(o);
      }
      hand_ = o == queue_.begin() ? queue_.end() : std::prev(o);
      objects_.erase(*o);
      queue_.erase(o);
    }
    queue_.push_front(x);
    objects_[x] = {};
    return false;
  }

 private:
  struct Object {
    bool visited = false;
  };
  std::list<Key> queue_;  // front is the head
  std::list<Key>::iterator hand_;
  std::unordered_map<Key, Object> objects_;
};

// Yang 2023, algorithm 1; its text clears the count of entries that move from S to M. M has nine
// tenths of the cache, G as many entries.
class S3Fifo final : public Cache {
 public:
  using Cache::Cache;
  bool request(Key x) override {
    if (s_.contains(x) || m_.contains(x)) {
      freq_[x] = std::min(freq_[x] + 1, 3);
      return true;
    }
    insert(x);
    freq_[x] = 0;
    return false;
  }

 private:
  void insert(Key x) {
    while (s_.size() + m_.size() >= c_) evict();
    if (g_.contains(x)) {
      g_.take(x);
      m_.pushHead(x);
    } else {
      s_.pushHead(x);
    }
  }
  void evict() {
    if (10 * s_.size() >= c_) {
      evictS();
    } else {
      evictM();
    }
  }
  void evictS() {
    bool evicted = false;
    while (!evicted && s_.size() > 0) {
      const Key t = s_.popTail();
      if (freq_[t] > 1) {
        m_.pushHead(t);
        freq_[t] = 0;
        if (10 * m_.size() > 9 * c_) evictM();
      } else {
        g_.pushHead(t);
        if (10 * g_.size() > 9 * c_) g_.popTail();
        evicted = true;
      }
    }
  }
  void evictM() {
    bool evicted = false;
    while (!evicted && m_.size() > 0) {
      const Key t = m_.tail();
      if (freq_[t] > 0) {
        m_.moveToHead(t);
        --freq_[t];
      } else {
        m_.take(t);
        evicted = true;
      }
    }
  }
  Queue s_, m_, g_;
  std::unordered_map<Key, int> freq_;
};

// Megiddo and Modha 2003, figure 4.
class Arc final : public Cache {
 public:
  using Cache::Cache;
  bool request(Key x) override {
    const auto b1 = static_cast<double>(b1_.size()), b2 = static_cast<double>(b2_.size());
    if (t1_.contains(x) || t2_.contains(x)) {  // case I
      (t1_.contains(x) ? t1_ : t2_).take(x);
      t2_.pushHead(x);
      return true;
    }
    if (b1_.contains(x)) {  // case II
      p_ = std::min(p_ + (b1 >= b2 ? 1 : b2 / b1), static_cast<double>(c_));
      replace(x);
      b1_.take(x);
      t2_.pushHead(x);
    } else if (b2_.contains(x)) {  // case III
      p_ = std::max(p_ - (b2 >= b1 ? 1 : b1 / b2), 0.0);
      replace(x);
      b2_.take(x);
      t2_.pushHead(x);
    } else {  // case IV
      missEverywhere(x);
      t1_.pushHead(x);
    }
    return false;
  }

 private:
  void missEverywhere(Key x) {
    const size_t l1 = t1_.size() + b1_.size(), l2 = t2_.size() + b2_.size();
    if (l1 == c_) {
      if (t1_.size() < c_) {
        b1_.popTail();
        replace(x);
      } else {
        t1_.popTail();
      }
    } else if (l1 + l2 >= c_) {
      if (l1 + l2 == 2 * c_) b2_.popTail();
      replace(x);
    }
  }
  void replace(Key x) {
    const auto t1 = static_cast<double>(t1_.size());
    if (t1_.size() >= 1 && ((b2_.contains(x) && t1 == p_) || t1 > p_)) {
      b1_.pushHead(t1_.popTail());
    } else {
      b2_.pushHead(t2_.popTail());
    }
  }
  Queue t1_, t2_, b1_, b2_;
  double p_ = 0;
};

// Johnson and Shasha 1994, the full version, with the shares that they recommend.
class TwoQ final : public Cache {
 public:
  explicit TwoQ(uint64_t capacity)
      : Cache(capacity),
        kin_(std::max<uint64_t>(1, capacity / 4)),
        kout_(std::max<uint64_t>(1, capacity / 2)) {}
  bool request(Key x) override {
    if (am_.contains(x)) {
      am_.moveToHead(x);
      return true;
    }
    if (a1out_.contains(x)) {
      a1out_.take(x);
      reclaim();
      am_.pushHead(x);
      return false;
    }
    if (a1in_.contains(x)) return true;
    reclaim();
    a1in_.pushHead(x);
    return false;
  }

 private:
  void reclaim() {
    if (a1in_.size() + am_.size() < c_) return;
    if (a1in_.size() > kin_ || am_.size() == 0) {
      a1out_.pushHead(a1in_.popTail());
      if (a1out_.size() > kout_) a1out_.popTail();
    } else {
      am_.popTail();
    }
  }
  const uint64_t kin_, kout_;
  Queue a1in_, a1out_, am_;
};

uint64_t beladyMisses(uint64_t capacity, std::span<const Key> requests) {
  constexpr size_t kNever = SIZE_MAX;
  std::vector<size_t> next(requests.size());
  std::unordered_map<Key, size_t> seen_at;
  for (size_t i = requests.size(); i-- > 0;) {
    const auto [at, is_new] = seen_at.try_emplace(requests[i], i);
    next[i] = is_new ? kNever : std::exchange(at->second, i);
  }
  uint64_t misses = 0;
  std::set<std::pair<size_t, Key>> by_next;
  std::unordered_map<Key, size_t> next_of;
  for (size_t i = 0; i < requests.size(); ++i) {
    const Key x = requests[i];
    const auto found = next_of.find(x);
    if (found != next_of.end()) {
      by_next.erase({found->second, x});
    } else {
      ++misses;
      if (next_of.size() == capacity) {
        next_of.erase(by_next.rbegin()->second);
        by_next.erase(std::prev(by_next.end()));
      }
    }
    next_of[x] = next[i];
    by_next.insert({next[i], x});
  }
  return misses;
}

template <class Policy>
uint64_t missesOf(uint64_t capacity, std::span<const Key> requests) {
  Policy cache(capacity);
  return static_cast<uint64_t>(
      std::count_if(requests.begin(), requests.end(), [&](Key x) { return !cache.request(x); }));
}

}  // namespace

uint64_t paperMisses(PolicyKind kind, uint64_t capacity, std::span<const Key> requests) {
  switch (kind) {
    case PolicyKind::kLru:
      return missesOf<Lru>(capacity, requests);
    case PolicyKind::kFifo:
      return missesOf<Fifo>(capacity, requests);
    case PolicyKind::kClock:
      return missesOf<Clock>(capacity, requests);
    case PolicyKind::kSieve:
      return missesOf<Sieve>(capacity, requests);
    case PolicyKind::kS3Fifo:
      return missesOf<S3Fifo>(capacity, requests);
    case PolicyKind::kArc:
      return missesOf<Arc>(capacity, requests);
    case PolicyKind::kTwoQ:
      return missesOf<TwoQ>(capacity, requests);
    case PolicyKind::kBelady:
      return beladyMisses(capacity, requests);
    default:
      break;
  }
  SLUICE_CHECK(!"a policy without a paper here");
  return 0;
}

}  // namespace sluice::test
