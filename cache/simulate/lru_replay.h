// LruReplay: LRU for simulation only, several times faster than LruPolicy, which it equals request
// for request (a test checks it).
//
// Instead of a linked list it keeps the log of requests, newest last. A key's place in the order is
// the time of its last request; a log entry is outdated when its key was requested again. Eviction
// walks the log from its old end, which is sequential memory, so a request touches one random word
// and an eviction another, both fetched ahead. It cannot pin or erase, and does not tell which keys
// were evicted. Memory O(keys): the log is packed when full. One thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cache/policies/flat_array.h"
#include "cache/policies/policy.h"
#include "cache/trace/prepared_trace.h"

namespace sluice {

class LruReplay {
 public:
  // `trace` must outlive it. Requires: capacity > 0.
  LruReplay(const PreparedTrace& trace, uint64_t capacity)
      : trace_(trace),
        capacity_(capacity),
        last_(trace.distinct, kAbsent),
        log_(std::max<size_t>(4096, 2 * size_t{trace.distinct})) {}

  // Requests keys in order; the caller replays all of the trace's.
  Outcome request(Key key) {
    if (head_ == log_.size()) pack();
    const uint32_t last = last_[key];
    if (last != kAbsent) {
      last_[key] = head_;
      log_[head_++] = key;
      return Outcome::kHit;
    }
    const uint64_t weight = trace_.weightOf(key);
    if (weight > capacity_) return Outcome::kDoesNotFit;
    while (used_ + weight > capacity_) evictOldest();
    used_ += weight;
    ++residents_;
    last_[key] = head_;
    log_[head_++] = key;
    return Outcome::kLoaded;
  }
  uint64_t used() const { return used_; }  // pages
  uint64_t residents() const { return residents_; }
  uint64_t evictions() const { return evictions_; }
  void prefetch(Key key) const { __builtin_prefetch(&last_[key], 1); }

 private:
  static constexpr uint32_t kAbsent = UINT32_MAX;
  static constexpr size_t kTailAhead = 16;

  void evictOldest() {
    if (tail_ + kTailAhead < head_) __builtin_prefetch(&last_[log_[tail_ + kTailAhead]], 1);
    const Key key = log_[tail_];
    if (last_[key] == tail_) {
      last_[key] = kAbsent;
      used_ -= trace_.weightOf(key);
      --residents_;
      ++evictions_;
    }
    ++tail_;
  }
  // Keeps the log entries that are their keys' last requests, in order.
  void pack() {
    uint32_t to = 0;
    for (uint32_t from = tail_; from < head_; ++from) {
      if (from + kTailAhead < head_) __builtin_prefetch(&last_[log_[from + kTailAhead]], 1);
      const Key key = log_[from];
      if (last_[key] != from) continue;
      last_[key] = to;
      log_[to++] = key;
    }
    tail_ = 0;
    head_ = to;
  }

  const PreparedTrace& trace_;
  const uint64_t capacity_;
  uint64_t used_ = 0;
  uint64_t evictions_ = 0;
  uint64_t residents_ = 0;
  uint32_t tail_ = 0, head_ = 0;  // the log is [tail_, head_)
  FlatArray<uint32_t> last_;      // by key: place in the log of its last request
  FlatArray<Key> log_;
};

}  // namespace sluice
