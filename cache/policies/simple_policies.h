// Policies that remember resident entries only: LRU, FIFO, CLOCK, random, SRRIP, SIEVE. Each keeps
// the contract of Policy; the comments describe the policy and how it treats entries of several
// pages and pinned entries, which the original does not have. One thread.
#pragma once

#include "cache/policies/policy.h"
#include "cache/policies/random.h"

namespace sluice {

// The least recently requested entry goes. Because victims are taken in order of age until the new
// entry fits, the residents are always the longest run of most recent entries that fits: LRU with
// entries of several pages is still a stack algorithm (stack_distance.h relies on it).
class LruPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  void onHit(uint32_t index) override { touch(index); }
  void onMiss(uint32_t index, uint32_t weight) override;
};

// The entry loaded first goes; a hit changes nothing.
class FifoPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  void onHit(uint32_t /*index*/) override {}
  void onMiss(uint32_t index, uint32_t weight) override;
};

// FIFO with a second chance: a hit sets the reference bit, which is clear after a load; the hand
// clears a set bit and passes on, and takes the first clear one. The ring is kept as a queue whose
// tail is under the hand: passing an entry moves it to the head. Pinned entries are skipped and
// keep their place.
class ClockPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  void onHit(uint32_t index) override { nodes_[index].mark = 1; }
  void onMiss(uint32_t index, uint32_t weight) override;
};

// Any resident entry goes, each with the same chance whatever its weight; the first unpinned one
// from the place drawn when that one is pinned.
class RandomPolicy final : public Policy {
 public:
  RandomPolicy(uint64_t capacity, uint64_t seed) : Policy(capacity), random_(seed) {}

 private:
  void onHit(uint32_t /*index*/) override {}
  void onMiss(uint32_t index, uint32_t weight) override;
  void onRemoval(uint32_t index) override;

  Random random_;
  std::vector<uint32_t> slots_;     // residents; a hole is filled by the last
  std::vector<uint32_t> position_;  // place of each node in slots_
};

// Static re-reference interval prediction (Jaleel 2010) with 2 bits and hit priority: loaded with a
// prediction of 2, a hit makes it 0; an entry with 3 goes, the one longest in that state first;
// when no unpinned one has 3, all predictions rise by one (3 stays 3). The original breaks ties by
// place in the set; a fully associative cache has none.
class SrripPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  static constexpr uint32_t kDistant = 3, kLong = 2;  // list number = prediction
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
};

// SIEVE (Zhang 2024): a queue in order of loading; a hit sets the visited bit; the hand goes from
// tail to head and round, clears visited bits, takes the first entry without one and stays there.
// It passes pinned entries without clearing their bit.
class SievePolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  static constexpr uint32_t kQueue = 0;
  void onHit(uint32_t index) override { nodes_[index].mark = 1; }
  void onMiss(uint32_t index, uint32_t weight) override;
  void onRemoval(uint32_t index) override;

  uint32_t hand_ = kQueue;  // the next to look at; the head's number: start at the tail
};

}  // namespace sluice
