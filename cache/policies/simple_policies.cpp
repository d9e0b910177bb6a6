#include "cache/policies/simple_policies.h"

namespace sluice {

// In all of these a victim exists while the entry does not fit: request() made sure that the
// unpinned residents weigh enough.

void LruPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) evict(oldestUnpinned(0));
  admit(index, weight, 0);
}

void FifoPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) evict(oldestUnpinned(0));
  admit(index, weight, 0);
}

void ClockPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) {
    const uint32_t at_hand = oldestUnpinned(0);
    if (nodes_[at_hand].mark == 0) {
      evict(at_hand);
    } else {
      nodes_[at_hand].mark = 0;
      touch(at_hand);
    }
  }
  admit(index, weight, 0);
}

void RandomPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) {
    size_t slot = random_.below(slots_.size());
    // The next one that is not pinned, so that many pins do not make the draw endless.
    while (nodes_[slots_[slot]].pinned) slot = (slot + 1) % slots_.size();
    evict(slots_[slot]);
  }
  admit(index, weight, 0);
  if (position_.size() < nodes_.size()) position_.resize(nodes_.size());
  position_[index] = static_cast<uint32_t>(slots_.size());
  slots_.push_back(index);
}

void RandomPolicy::onRemoval(uint32_t index) {
  const uint32_t hole = position_[index];
  slots_[hole] = slots_.back();
  position_[slots_[hole]] = hole;
  slots_.pop_back();
}

void SrripPolicy::onHit(uint32_t index) {
  unlink(index);
  pushHead(0, index);
}

void SrripPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) {
    const uint32_t victim = oldestUnpinned(kDistant);
    if (victim != kDistant) {
      evict(victim);
    } else {
      // Nothing is due, so all entries come one step closer, as if each was counted up.
      for (uint32_t list = kDistant; list > 0; --list) spliceToHead(list - 1, list);
    }
  }
  admit(index, weight, kLong);
}

void SievePolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) {
    // Past the newest entry the hand goes on at the oldest.
    if (hand_ == kQueue) hand_ = tail(kQueue);
    Node& node = nodes_[hand_];
    if (node.pinned || node.mark != 0) {
      if (!node.pinned) node.mark = 0;
      hand_ = node.prev;
    } else {
      evict(hand_);
    }
  }
  admit(index, weight, kQueue);
}

void SievePolicy::onRemoval(uint32_t index) {
  if (hand_ == index) hand_ = nodes_[index].prev;
}

}  // namespace sluice
