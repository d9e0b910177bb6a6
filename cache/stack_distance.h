// StackDistances: LRU stack distances in O(log n) a request (Mattson 1970; the tree over times of
// last request is Bennett and Kruskal's, 1975).
//
// The distance of a request is the weight of the distinct keys requested since the key's last
// request, itself included: an LRU cache of at least that many pages hits, a smaller one misses.
// For keys of several pages this is exact too, because LRU that evicts until the new entry fits
// holds the longest run of most recent keys that fits (simple_policies.h); only below the heaviest
// key's pages, where requests that do not fit leave a real cache unchanged, is it not.
//
// Memory is O(distinct keys): positions are used up one a request and packed again when they run
// out, every n-th request for n distinct keys. `Rank` is UnitRank (all weights 1) or WeightRank.
// One thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cache/policy.h"
#include "cache/rank_index.h"
#include "src/base/error.h"

namespace sluice {

template <class Rank>
class StackDistances {
 public:
  static constexpr uint64_t kCold = UINT64_MAX;  // the first request of a key

  // Keys are below `keys`, which may grow later at a cost.
  explicit StackDistances(size_t keys) : position_of_(keys, kNowhere) {
    resizePositions(std::max<size_t>(2 * keys, kFewestPositions));
  }

  // The distance of the next request. Requires: weight > 0, the same each time for a key.
  uint64_t request(Key key, uint64_t weight) {
    if (key >= position_of_.size()) position_of_.resize(size_t{key} * 2 + 1, kNowhere);
    if (next_ == owner_.size()) pack();
    const uint32_t last = position_of_[key];
    uint64_t distance = kCold;
    if (last != kNowhere) {
      distance = rank_.after(last) + weight;
      rank_.remove(last, weight);
      owner_[last] = kNobody;
    } else {
      ++live_;
    }
    rank_.add(next_, weight);
    owner_[next_] = {key, weight};
    position_of_[key] = next_++;
    return distance;
  }
  // Forgets a key. Requires: it has been requested and not been forgotten since.
  void forget(Key key) {
    const uint32_t last = position_of_[key];
    rank_.remove(last, owner_[last].weight);
    owner_[last] = kNobody;
    position_of_[key] = kNowhere;
    --live_;
  }

  // Hints, the first well ahead of the second, the second ahead of request().
  void prefetchPosition(Key key) const {
    if (key < position_of_.size()) __builtin_prefetch(&position_of_[key]);
  }
  void prefetchRank(Key key) const {
    if (key < position_of_.size() && position_of_[key] != kNowhere) {
      rank_.prefetch(position_of_[key]);
      __builtin_prefetch(&owner_[position_of_[key]]);
    }
  }

 private:
  struct Owner {
    Key key = UINT32_MAX;
    uint64_t weight = 0;
  };
  static constexpr uint32_t kNowhere = UINT32_MAX;
  static constexpr size_t kFewestPositions = 4096;
  static constexpr Owner kNobody{};

  void resizePositions(size_t positions) {
    SLUICE_CHECK_LT(positions, size_t{kNowhere});
    owner_.resize(positions, kNobody);
    rank_.clear(positions);
  }
  // Moves the live positions to the front, in order; twice as many positions as live ones remain.
  void pack() {
    uint32_t to = 0;
    for (uint32_t from = 0; from < next_; ++from) {
      if (owner_[from].weight == 0) continue;
      owner_[to] = owner_[from];
      position_of_[owner_[to].key] = to;
      ++to;
    }
    std::fill(owner_.begin() + to, owner_.end(), kNobody);
    resizePositions(std::max(owner_.size(), 2 * size_t{live_}));
    next_ = to;
    for (uint32_t p = 0; p < to; ++p) rank_.add(p, owner_[p].weight);
  }

  std::vector<uint32_t> position_of_;  // by key
  std::vector<Owner> owner_;           // by position
  Rank rank_;
  uint32_t next_ = 0;  // the first position not used yet
  uint32_t live_ = 0;  // keys with a position
};

}  // namespace sluice
