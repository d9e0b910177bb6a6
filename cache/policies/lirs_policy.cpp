#include "cache/policies/lirs_policy.h"

#include <algorithm>

namespace sluice {
namespace {

constexpr uint64_t kQueueShare = 100;  // a page in so many
constexpr uint32_t kHead = 0;

}  // namespace

LirsPolicy::LirsPolicy(uint64_t capacity)
    : Policy(capacity),
      lir_pages_(capacity - std::max<uint64_t>(1, capacity / kQueueShare)),
      ghost_pages_(2 * capacity),
      stack_(1) {}

void LirsPolicy::takeOffStack(uint32_t index) {
  Links& links = stack_[index];
  stack_[links.above].below = links.below;
  stack_[links.below].above = links.above;
  links.is_in = false;
}

void LirsPolicy::putOnStack(uint32_t index) {
  if (stack_.size() < nodes_.size()) stack_.resize(nodes_.size());
  if (stack_[index].is_in) takeOffStack(index);
  stack_[index] = {kHead, stack_[kHead].below, true};
  stack_[stack_[kHead].below].above = index;
  stack_[kHead].below = index;
}

void LirsPolicy::prune() {
  for (uint32_t last = stack_[kHead].above; last != kHead; last = stack_[kHead].above) {
    const Node& node = nodes_[last];
    // Stack pruning (Jiang and Zhang 2002): the stack ends with a LIR entry.
    if (node.resident && node.list == kLir) return;
    takeOffStack(last);
    // A ghost is only remembered while it is in the stack.
    if (!node.resident && isLinked(last)) unlink(last);
  }
}

void LirsPolicy::demote() {
  while (listWeight(kLir) > lir_pages_) {
    prune();
    const uint32_t last = stack_[kHead].above;
    takeOffStack(last);
    unlink(last);
    pushHead(kQueue, last);
  }
}

void LirsPolicy::onHit(uint32_t index) {
  const bool was_lir = nodes_[index].list == kLir;
  // A HIR entry in the stack was requested again sooner than the lowest LIR one.
  const bool becomes_lir = was_lir || isInStack(index);
  putOnStack(index);
  if (!was_lir) {
    unlink(index);
    pushHead(becomes_lir ? kLir : kQueue, index);
  }
  demote();
  prune();
}

uint32_t LirsPolicy::lowestLir() const {
  uint32_t at = stack_[kHead].above;
  while (nodes_[at].pinned || !nodes_[at].resident || nodes_[at].list != kLir)
    at = stack_[at].above;
  return at;
}

void LirsPolicy::makeRoom(uint32_t weight) {
  while (isFull(weight)) {
    const uint32_t oldest = oldestUnpinned(kQueue);
    // All of the queue is pinned, so a LIR entry has to go.
    if (oldest == kQueue) {
      evict(lowestLir());
      continue;
    }
    evict(oldest);
    // Without its place in the stack, nothing would tell how long ago it was requested.
    if (!isInStack(oldest)) continue;
    pushHead(kGhost, oldest);
    while (listWeight(kGhost) > ghost_pages_) {
      const uint32_t forgotten = tail(kGhost);
      unlink(forgotten);
      takeOffStack(forgotten);
    }
  }
}

void LirsPolicy::onMiss(uint32_t index, uint32_t weight) {
  makeRoom(weight);
  // Making room may have cost the ghost its place.
  const bool remembered = isLinked(index);
  if (remembered) unlink(index);
  const bool has_lir_room = listWeight(kLir) + weight <= lir_pages_;
  admit(index, weight, remembered || has_lir_room ? kLir : kQueue);
  putOnStack(index);
  demote();
  prune();
}

// A LIR entry leaves the stack with the cache. A HIR one stays in the stack as a ghost if it was
// evicted; erased ones are holes, which are no ghosts since they are in no list.
void LirsPolicy::onRemoval(uint32_t index) {
  if (nodes_[index].list != kLir) return;
  takeOffStack(index);
  prune();
}

}  // namespace sluice
