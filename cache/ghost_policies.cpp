#include "cache/ghost_policies.h"

#include <algorithm>

namespace sluice {

TwoQPolicy::TwoQPolicy(uint64_t capacity)
    : Policy(capacity),
      in_pages_(std::max<uint64_t>(1, capacity / 4)),
      out_pages_(std::max<uint64_t>(1, capacity / 2)) {}

void TwoQPolicy::onHit(uint32_t index) {
  if (nodes_[index].list == kMain) touch(index);
}

void TwoQPolicy::onMiss(uint32_t index, uint32_t weight) {
  const bool remembered = isLinked(index);
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
    const uint64_t b1 = std::max<uint64_t>(1, listWeight(kB1));
    const uint64_t b2 = std::max<uint64_t>(1, listWeight(kB2));
    if (was_in_b2) {
      target_t1_ -= std::min(target_t1_, weight * std::max<uint64_t>(1, b1 / b2));
    } else {
      target_t1_ = std::min(capacity(), target_t1_ + weight * std::max<uint64_t>(1, b2 / b1));
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
  const uint64_t t1 = listWeight(kT1);
  const bool t1_is_over = t1 > target_t1_ || (was_in_b2 && t1 == target_t1_);
  if (from_t1 != kT1 && (t1_is_over || from_t2 == kT2)) {
    evict(from_t1);
    pushHead(kB1, from_t1);
  } else {
    evict(from_t2);
    pushHead(kB2, from_t2);
  }
}

S3FifoPolicy::S3FifoPolicy(uint64_t capacity)
    : Policy(capacity),
      small_pages_(std::max<uint64_t>(1, capacity / 10)),
      ghost_pages_(std::max<uint64_t>(1, capacity - capacity / 10)) {}

void S3FifoPolicy::onHit(uint32_t index) {
  nodes_[index].mark = std::min<uint8_t>(3, nodes_[index].mark + 1);
}

void S3FifoPolicy::onMiss(uint32_t index, uint32_t weight) {
  const bool remembered = isLinked(index);
  if (remembered) unlink(index);
  while (isFull(weight)) {
    const uint32_t from_small = oldestUnpinned(kSmall);
    const uint32_t from_main = oldestUnpinned(kMain);
    if (from_small != kSmall && (listWeight(kSmall) >= small_pages_ || from_main == kMain)) {
      stepSmall(from_small);
    } else {
      stepMain(from_main);
    }
  }
  admit(index, weight, remembered ? kMain : kSmall);
}

void S3FifoPolicy::stepSmall(uint32_t oldest) {
  if (nodes_[oldest].mark > 1) {
    unlink(oldest);
    nodes_[oldest].mark = 0;
    pushHead(kMain, oldest);
    return;
  }
  evict(oldest);
  pushHead(kGhost, oldest);
  while (listWeight(kGhost) > ghost_pages_) unlink(tail(kGhost));
}

void S3FifoPolicy::stepMain(uint32_t oldest) {
  if (nodes_[oldest].mark == 0) {
    evict(oldest);
  } else {
    --nodes_[oldest].mark;
    touch(oldest);
  }
}

}  // namespace sluice
