// Policies that also remember the entries that they evicted, in ghost lists of keys without pages:
// 2Q, ARC and S3-FIFO. A list's size is the sum of its entries' weights in pages. So each policy is
// the original if all entries have one page, and shares of the cache remain shares of pages if
// entries are larger. If a step would evict from a list that holds only pinned entries, it evicts
// from the other list. One thread.
#pragma once

#include "cache/policies/policy.h"

namespace sluice {

// 2Q, the full version (Johnson and Shasha 1994): new entries enter the queue In (a quarter of the
// pages). Entries that fall out of it are remembered in Out (half as many pages as the cache has)
// and enter the LRU list Main when they are requested from there. A hit in In changes nothing.
class TwoQPolicy final : public Policy {
 public:
  explicit TwoQPolicy(uint64_t capacity);

 private:
  static constexpr uint32_t kIn = 0, kMain = 1, kOut = 2;
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;

  const uint64_t in_pages_, out_pages_;
};

// ARC (Megiddo and Modha 2003, figure 4): recent entries T1 and frequent ones T2, their ghosts B1
// and B2, and a target size of T1, a real number, that a request for a ghost moves by its weight
// times max(1, ratio of the ghost lists' sizes). REPLACE is repeated until the entry fits.
class ArcPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  static constexpr uint32_t kT1 = 0, kT2 = 1, kB1 = 2, kB2 = 3;
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  void trimGhosts(uint32_t weight);
  void replace(bool was_in_b2);

  double target_t1_ = 0;  // pages; p in the paper
};

// S3-FIFO (Yang 2023, algorithm 1): new entries enter the queue Small (a tenth of the pages),
// ghosts the queue Main (the rest). An eviction takes from Small while Small holds its share or
// more, else from Main. The oldest entries of Small move to Main, their count cleared, if they were
// hit more than once; the first that was not becomes a ghost. If such a move takes Main beyond its
// share, Main evicts one entry too. The oldest entry of Main moves to the end with its count (at
// most 3) reduced by one, until it is 0. Ghosts are kept for as many pages as Main's share. Shares
// are real numbers: of 25 pages, Small has its share with 3, Main with 22.
class S3FifoPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  static constexpr uint32_t kSmall = 0, kMain = 1, kGhost = 2;
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  bool isSmallFull() const { return 10 * listWeight(kSmall) >= capacity(); }
  bool isOverMainsShare(uint64_t pages) const { return 10 * pages > 9 * capacity(); }
  void evictFromSmall();
  void evictFromMain();
};

}  // namespace sluice
