// StackDistances: LRU stack distances in O(log n) a request (Mattson 1970; the tree over times of
// last request is Bennett and Kruskal's, 1975).
//
// The distance of a request is the weight of the distinct keys requested since the key's last
// request, itself included: an LRU cache of at least that many pages hits, a smaller one misses.
// For keys of several pages this is exact too, because LRU that evicts until the new entry fits
// holds the longest run of most recent keys that fits (simple_policies.h). It is not exact below
// the heaviest key's pages, since requests that do not fit leave a real cache unchanged.
//
// Memory is O(distinct keys): positions are used up one a request and packed again when they run
// out, after 3n or more requests for n distinct keys. `Rank` is UnitRank (all weights 1) or
// WeightRank. One thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cache/policies/flat_array.h"
#include "cache/policies/policy.h"
#include "cache/simulate/rank_index.h"
#include "src/base/error.h"

namespace sluice {

template <class Rank>
class StackDistances {
 public:
  static constexpr uint64_t kCold = UINT64_MAX;  // the first request of a key

  // Keys are below `keys`, which may grow later at a cost.
  explicit StackDistances(size_t keys) {
    growKeys(keys);
    takePositions(std::max(kSlack * keys, kFewestPositions), 0);
  }

  // The distance of the next request. Requires: weight > 0, the same each time for a key.
  uint64_t request(Key key, uint64_t weight) {
    if (key >= position_of_.size()) growKeys(size_t{key} * 2 + 1);
    if (next_ == owner_.size()) pack();
    const uint32_t last = position_of_[key];
    uint64_t distance = kCold;
    if (last != kNowhere) {
      distance = rank_.after(last) + weight;
      rank_.remove(last, weight);
    } else {
      ++live_;
      if constexpr (Rank::kWeighted) weight_of_[key] = weight;
    }
    rank_.add(next_, weight);
    owner_[next_] = key;
    position_of_[key] = next_++;
    return distance;
  }
  // Forgets a key. Requires: it has been requested and not been forgotten since.
  void forget(Key key) {
    rank_.remove(position_of_[key], weightOf(key));
    position_of_[key] = kNowhere;
    --live_;
  }

  // Hints, the first well ahead of the second, the second ahead of request().
  void prefetchPosition(Key key) const {
    if (key < position_of_.size()) __builtin_prefetch(&position_of_[key]);
  }
  void prefetchRank(Key key) const {
    if (key < position_of_.size() && position_of_[key] != kNowhere)
      rank_.prefetch(position_of_[key]);
  }

 private:
  static constexpr uint32_t kNowhere = UINT32_MAX;
  static constexpr size_t kFewestPositions = 4096;
  static constexpr size_t kSlack = 4;  // positions a key: packed every 3n requests at worst
  static constexpr uint32_t kPackAhead = 16;

  uint64_t weightOf(Key key) const {
    if constexpr (Rank::kWeighted) return weight_of_[key];
    return 1;
  }
  void growKeys(size_t keys) {
    position_of_.resize(keys, kNowhere);
    if constexpr (Rank::kWeighted) weight_of_.resize(keys, 0);
  }
  // `positions` of them from now on, the first `first` taken.
  void takePositions(size_t positions, uint32_t first) {
    SLUICE_CHECK_LT(positions, size_t{kNowhere});
    owner_.resize(positions);
    rank_.reset(positions, first, [&](size_t p) { return weightOf(owner_[p]); });
    next_ = first;
  }
  bool isLive(uint32_t position) const {
    if constexpr (Rank::kWeighted) return position_of_[owner_[position]] == position;
    // The same answer from memory in order.
    else
      return rank_.isTaken(position);
  }
  // Moves the live positions to the front, in order.
  void pack() {
    uint32_t to = 0;
    for (uint32_t from = 0; from < next_; ++from) {
      if (!isLive(from)) continue;
      owner_[to++] = owner_[from];
    }
    for (uint32_t p = 0; p < to; ++p) {
      if (p + kPackAhead < to) __builtin_prefetch(&position_of_[owner_[p + kPackAhead]], 1);
      position_of_[owner_[p]] = p;
    }
    takePositions(std::max(owner_.size(), kSlack * live_), to);
  }

  FlatArray<uint32_t> position_of_;  // by key
  std::vector<uint64_t> weight_of_;  // by key; with WeightRank only
  FlatArray<Key> owner_;             // by position; live if position_of_ refers to it
  Rank rank_;
  uint32_t next_ = 0;  // the first position not used yet
  uint32_t live_ = 0;  // keys with a position
};

}  // namespace sluice
