// Policies that evict the entry of the lowest priority, which follows from how often an entry was
// requested: LFU and GDSF. Both keep a binary heap over the resident entries, so a request costs
// O(log residents). Pinned entries are skipped. One thread.
#pragma once

#include <vector>

#include "cache/policies/policy.h"

namespace sluice {

// A heap of resident entries by (priority, time of the last request), lowest first. `Derived`
// defines the priority.
class PriorityPolicy : public Policy {
 public:
  using Policy::Policy;

 protected:
  // The priority of an entry of `weight` pages that has been requested `times` times since it was
  // loaded.
  virtual double priorityOf(uint32_t times, uint32_t weight) const = 0;
  virtual void onEviction(double /*priority*/) {}

 private:
  struct Entry {
    double priority = 0;
    uint64_t last_request = 0;  // breaks ties: the one requested longest ago goes first
    uint32_t times = 0;
    uint32_t place = 0;  // in heap_
  };
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  void onRemoval(uint32_t index) override;
  bool goesBefore(uint32_t a, uint32_t b) const;
  void put(uint32_t index, size_t place);
  void rise(uint32_t index);
  void sink(uint32_t index);
  void evictLowest();
  void takeBackPassed();

  std::vector<Entry> entries_;    // by node
  std::vector<uint32_t> heap_;    // nodes of the residents
  std::vector<uint32_t> passed_;  // pinned ones, taken off the heap while a victim is looked for
};

// LFU: the entry requested least often since it was loaded goes. Its pages do not matter.
class LfuPolicy final : public PriorityPolicy {
 public:
  using PriorityPolicy::PriorityPolicy;

 private:
  double priorityOf(uint32_t times, uint32_t /*weight*/) const override { return times; }
};

// GDSF, Greedy-Dual-Size-Frequency (Cherkasova 1998) with a cost of 1 a request: the priority is L
// + times / pages, with L the priority of the entry evicted last, so that entries age. Small
// entries that are requested often stay. The original may leave out the new entry itself; the
// renderer needs it, so here it always comes in.
class GdsfPolicy final : public PriorityPolicy {
 public:
  using PriorityPolicy::PriorityPolicy;

 private:
  double priorityOf(uint32_t times, uint32_t weight) const override {
    return age_ + static_cast<double>(times) / weight;
  }
  void onEviction(double priority) override { age_ = priority; }

  double age_ = 0;  // L; never falls while nothing is pinned
};

}  // namespace sluice
