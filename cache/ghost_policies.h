// The policies that also remember what they evicted, in ghost lists of keys without pages: 2Q, ARC
// and S3-FIFO. Every list's size is the sum of its entries' weights in pages, so that with entries
// of one page each is the original and with larger ones the shares stay shares of pages. Where a
// step would evict from a list that holds only pinned entries, the other list gives. One thread.
#pragma once

#include "cache/policy.h"

namespace sluice {

// 2Q, the full version (Johnson and Shasha 1994): new entries enter the queue In (a quarter of the
// pages), what falls out of it is remembered in Out (half as many pages as the cache has) and
// enters the LRU list Main when it is requested from there. A hit in In changes nothing.
class TwoQPolicy final : public Policy {
 public:
  explicit TwoQPolicy(uint64_t capacity);

 private:
  static constexpr uint32_t kIn = 0, kMain = 1, kOut = 2;
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;

  const uint64_t in_pages_, out_pages_;
};

// ARC (Megiddo and Modha 2003): recent entries T1 and frequent ones T2, their ghosts B1 and B2, and
// a target size of T1 that a request for a ghost moves by its weight times max(1, ratio of the
// ghost lists' sizes, rounded down). REPLACE is repeated until the entry fits.
class ArcPolicy final : public Policy {
 public:
  using Policy::Policy;

 private:
  static constexpr uint32_t kT1 = 0, kT2 = 1, kB1 = 2, kB2 = 3;
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  void trimGhosts(uint32_t weight);
  void replace(bool was_in_b2);

  uint64_t target_t1_ = 0;  // pages
};

// S3-FIFO (Yang 2023): new entries enter the queue Small (a tenth of the pages), ghosts the queue
// Main. Small's oldest moves to Main with its count cleared when it was hit more than once, else it
// becomes a ghost; Main's oldest goes round with its count (at most 3) one less until it is 0.
// Small gives while it holds its share or more. Ghosts are kept for as many pages as Main has.
class S3FifoPolicy final : public Policy {
 public:
  explicit S3FifoPolicy(uint64_t capacity);

 private:
  static constexpr uint32_t kSmall = 0, kMain = 1, kGhost = 2;
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  void stepSmall(uint32_t oldest);
  void stepMain(uint32_t oldest);

  const uint64_t small_pages_, ghost_pages_;
};

}  // namespace sluice
