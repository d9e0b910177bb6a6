// Naive replacement policies: each written down plainly from the description in cache/*.h, with
// lists of keys that are searched from end to end, to compare the real ones with request by
// request.
#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "cache/policies/policy.h"

namespace sluice::test {

class NaivePolicy {
 public:
  explicit NaivePolicy(uint64_t capacity) : capacity_(capacity) {}
  virtual ~NaivePolicy() = default;

  Outcome request(Key key, uint32_t weight, std::vector<Key>& evicted) {
    ++requests_;
    if (weights_.contains(key)) {
      hit(key);
      return Outcome::kHit;
    }
    uint64_t pinned = 0;
    for (const Key k : pinned_) pinned += weights_.at(k);
    if (weight > capacity_ - pinned) return Outcome::kDoesNotFit;
    evicted_ = &evicted;
    miss(key, weight);
    weights_[key] = weight;
    return Outcome::kLoaded;
  }
  void pin(Key key) {
    if (weights_.contains(key)) pinned_.insert(key);
  }
  void unpinAll() { pinned_.clear(); }
  bool erase(Key key) {
    if (!weights_.contains(key)) {
      forgetGhost(key);
      return false;
    }
    removed(key);
    weights_.erase(key);
    pinned_.erase(key);
    return true;
  }

 protected:
  virtual void hit(Key key) = 0;
  virtual void miss(Key key, uint32_t weight) = 0;
  virtual void removed(Key key) = 0;  // takes a resident key out of the policy's lists
  virtual void forgetGhost(Key /*key*/) {}

  uint64_t used() const {
    uint64_t sum = 0;
    for (const auto& [k, w] : weights_) sum += w;
    return sum;
  }
  bool full(uint32_t weight) const { return used() + weight > capacity_; }
  void evict(Key key) {
    removed(key);
    weights_.erase(key);
    evicted_->push_back(key);
  }
  // Front is newest. The oldest key not pinned, or nullptr.
  const Key* oldest(const std::list<Key>& list) const {
    for (auto i = list.rbegin(); i != list.rend(); ++i) {
      if (!pinned_.contains(*i)) return &*i;
    }
    return nullptr;
  }

  const uint64_t capacity_;
  uint64_t requests_ = 0;
  std::map<Key, uint32_t> weights_;  // weights of resident keys
  std::set<Key> pinned_;
  std::vector<Key>* evicted_ = nullptr;
};

// `next_uses` is for Belady's optimum.
std::unique_ptr<NaivePolicy> makeNaivePolicy(PolicyKind kind, uint64_t capacity, uint64_t seed,
                                             const std::vector<uint32_t>& next_uses = {});
// Its part for policies that remember evicted entries: kTwoQ, kArc and kS3Fifo.
std::unique_ptr<NaivePolicy> makeNaiveGhostPolicy(PolicyKind kind, uint64_t capacity);
// Its part for kLfu, kSlru, kWTinyLfu, kLirs and kGdsf.
std::unique_ptr<NaivePolicy> makeNaiveCountingPolicy(PolicyKind kind, uint64_t capacity);

}  // namespace sluice::test
