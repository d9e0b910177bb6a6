// Policies that keep entries requested again apart from the others: SLRU, and W-TinyLFU, whose main
// part is an SLRU. Shares are of pages. One thread.
#pragma once

#include "cache/policies/policy.h"

namespace sluice {

// Two LRU lists, as SLRU has them: Probation takes new entries, Protected those that were hit
// there. While Protected holds more than its share, its oldest goes back to the head of Probation,
// pinned or not: it stays resident.
class SegmentedPolicy : public Policy {
 public:
  // `segmented_pages`: how many pages both lists have together; Protected has four fifths of them.
  SegmentedPolicy(uint64_t capacity, uint64_t segmented_pages);

 protected:
  static constexpr uint32_t kProbation = 0, kProtected = 1, kWindow = 2;
  void onHit(uint32_t index) override;
  // The next to be evicted: Probation's oldest, or else Protected's; kNone if all are pinned.
  static constexpr uint32_t kNone = UINT32_MAX;
  uint32_t segmentedVictim() const;

 private:
  const uint64_t protected_pages_;
};

// SLRU, segmented LRU (Karedla 1994), with four fifths of the pages protected.
class SlruPolicy final : public SegmentedPolicy {
 public:
  explicit SlruPolicy(uint64_t capacity) : SegmentedPolicy(capacity, capacity) {}

 private:
  void onMiss(uint32_t index, uint32_t weight) override;
};

// W-TinyLFU (Einziger, Friedman and Manes 2017): a window, an LRU list of a hundredth of the pages,
// takes new entries. An entry that falls out of it enters the main part, an SLRU, only if it was
// requested more often than the entry that would be evicted for it. Counts stop at 15. Once ten
// requests a page of the cache are counted, all counts halve, that of the requests among them. The
// paper keeps them in a sketch to save memory; here they are exact, a few bytes a key. The new
// entry itself always comes in, since the renderer needs it.
class WTinyLfuPolicy final : public SegmentedPolicy {
 public:
  explicit WTinyLfuPolicy(uint64_t capacity);

 private:
  struct Count {
    uint64_t halvings = 0;  // halvings already applied to `times`
    uint8_t times = 0;
  };
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  void count(uint32_t index);
  uint8_t timesOf(uint32_t index) const;
  bool isWindowOver(uint32_t weight) const { return listWeight(kWindow) + weight > window_pages_; }
  void toMain(uint32_t index);

  const uint64_t window_pages_, sample_;
  uint64_t halvings_ = 0, counted_ = 0;  // requests
  std::vector<Count> counts_;            // by node
};

}  // namespace sluice
