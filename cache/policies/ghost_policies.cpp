#include "cache/policies/ghost_policies.h"

#include <algorithm>

namespace sluice {

TwoQPolicy::TwoQPolicy(uint64_t capacity)
    : Policy(capacity),
      // Johnson and Shasha (1994) suggest a quarter of the cache for In and half of it for Out.
      in_pages_(std::max<uint64_t>(1, capacity / 4)),
      out_pages_(std::max<uint64_t>(1, capacity / 2)) {}

void TwoQPolicy::onHit(uint32_t index) {
  // A hit in In moves nothing: requests that follow each other closely are one use.
  if (nodes_[index].list == kMain) touch(index);
}

void TwoQPolicy::onMiss(uint32_t index, uint32_t weight) {
  const bool remembered = isLinked(index);
  // A request for a chunk that Out remembers is what brings it into the main list.
  if (remembered) unlink(index);
  while (isFull(weight)) {
    const uint32_t from_in = oldestUnpinned(kIn);
    const uint32_t from_main = oldestUnpinned(kMain);
    const bool in_gives = from_main == kMain || (listWeight(kIn) > in_pages_ && from_in != kIn);
    if (in_gives) {
      evict(from_in);
      pushHead(kOut, from_in);
      while (listWeight(kOut) > out_pages_) unlink(tail(kOut));
    } else {
      evict(from_main);
    }
  }
  admit(index, weight, remembered ? kMain : kIn);
}

void ArcPolicy::onHit(uint32_t index) {
  unlink(index);
  pushHead(kT2, index);
}

void ArcPolicy::onMiss(uint32_t index, uint32_t weight) {
  const bool remembered = isLinked(index);
  const bool was_in_b2 = remembered && nodes_[index].list == kB2;
  if (remembered) {
    // Megiddo and Modha (2003): a hit in a ghost list shows that its side is too small, and counts
    // for more if that list is the shorter one.
    const auto b1 = static_cast<double>(listWeight(kB1));
    const auto b2 = static_cast<double>(listWeight(kB2));
    if (was_in_b2) {
      target_t1_ = std::max(0.0, target_t1_ - weight * std::max(1.0, b1 / b2));
    } else {
      target_t1_ =
          std::min(static_cast<double>(capacity()), target_t1_ + weight * std::max(1.0, b2 / b1));
    }
    unlink(index);
  } else {
    trimGhosts(weight);
  }
  while (isFull(weight)) replace(was_in_b2);
  admit(index, weight, remembered ? kT2 : kT1);
}

// Keeps T1 + B1 within the capacity and all four lists within twice of it, the new entry counted.
void ArcPolicy::trimGhosts(uint32_t weight) {
  while (listWeight(kT1) + listWeight(kB1) + weight > capacity()) {
    if (!isEmpty(kB1)) {
      unlink(tail(kB1));
      continue;
    }
    const uint32_t oldest = oldestUnpinned(kT1);
    if (oldest == kT1) break;
    evict(oldest);
  }
  while (used() + listWeight(kB1) + listWeight(kB2) + weight > 2 * capacity() && !isEmpty(kB2))
    unlink(tail(kB2));
}

void ArcPolicy::replace(bool was_in_b2) {
  const uint32_t from_t1 = oldestUnpinned(kT1);
  const uint32_t from_t2 = oldestUnpinned(kT2);
  const auto t1 = static_cast<double>(listWeight(kT1));
  const bool t1_is_over = t1 > target_t1_ || (was_in_b2 && t1 == target_t1_);
  if (from_t1 != kT1 && (t1_is_over || from_t2 == kT2)) {
    evict(from_t1);
    pushHead(kB1, from_t1);
  } else {
    evict(from_t2);
    pushHead(kB2, from_t2);
  }
}

void S3FifoPolicy::onHit(uint32_t index) {
  // Two bits of frequency (Yang et al. 2023).
  nodes_[index].mark = std::min<uint8_t>(3, nodes_[index].mark + 1);
}

void S3FifoPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) {
    const bool small_can = oldestUnpinned(kSmall) != kSmall;
    const bool main_can = oldestUnpinned(kMain) != kMain;
    if (small_can && (isSmallFull() || !main_can)) {
      evictFromSmall();
    } else {
      evictFromMain();
    }
  }
  // Making room may have cost the ghost its place.
  const bool remembered = isLinked(index);
  if (remembered) unlink(index);
  admit(index, weight, remembered ? kMain : kSmall);
}

void S3FifoPolicy::evictFromSmall() {
  for (uint32_t oldest = oldestUnpinned(kSmall); oldest != kSmall;
       oldest = oldestUnpinned(kSmall)) {
    // Requested at most once more since it came: it leaves after a short stay, and is remembered.
    if (nodes_[oldest].mark <= 1) {
      evict(oldest);
      pushHead(kGhost, oldest);
      while (isOverMainsShare(listWeight(kGhost))) unlink(tail(kGhost));
      return;
    }
    unlink(oldest);
    nodes_[oldest].mark = 0;
    pushHead(kMain, oldest);
    // An entry that moves up takes room from the main list, which may not outgrow its share.
    if (isOverMainsShare(listWeight(kMain))) evictFromMain();
  }
}

void S3FifoPolicy::evictFromMain() {
  for (uint32_t oldest = oldestUnpinned(kMain); oldest != kMain; oldest = oldestUnpinned(kMain)) {
    if (nodes_[oldest].mark == 0) {
      evict(oldest);
      return;
    }
    // A requested entry gets another round for each count.
    --nodes_[oldest].mark;
    touch(oldest);
  }
}

}  // namespace sluice
