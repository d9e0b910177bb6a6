// LIRS (Jiang and Zhang 2002): entries whose last two requests lie close together stay.
//
// Entries are of low inter-reference recency (LIR) or of high (HIR). HIR entries have a hundredth
// of the pages, at least one, and go first, from a queue in order of entry. A stack orders entries
// by their last request, ghosts included. It always ends with a LIR entry: everything below the
// last LIR entry is taken out. A HIR entry or a ghost that is requested while it is in the stack
// becomes LIR, as does every new one while LIR entries have room in their share, and the lowest LIR
// entries of the stack become HIR until LIR entries are within their share. Ghosts are kept for
// twice the cache's pages, the oldest one goes first; the paper's stack has no such limit. Pinned
// entries are skipped, and if the queue has no other, the lowest LIR entry is evicted, without
// becoming a ghost. One thread.
#pragma once

#include <vector>

#include "cache/policies/policy.h"

namespace sluice {

class LirsPolicy final : public Policy {
 public:
  explicit LirsPolicy(uint64_t capacity);

 private:
  static constexpr uint32_t kLir = 0, kQueue = 1, kGhost = 2;
  // The stack is a second list through the nodes, its head is place 0.
  struct Links {
    uint32_t above = 0, below = 0;
    bool is_in = false;
  };
  void onHit(uint32_t index) override;
  void onMiss(uint32_t index, uint32_t weight) override;
  void onRemoval(uint32_t index) override;

  bool isInStack(uint32_t index) const { return index < stack_.size() && stack_[index].is_in; }
  void takeOffStack(uint32_t index);
  void putOnStack(uint32_t index);  // to the top, wherever it was
  void makeRoom(uint32_t weight);
  // The unpinned LIR entry deepest in the stack. Requires: there is one.
  uint32_t lowestLir() const;
  // LIR entries become HIR, from the bottom, until they are within their share.
  void demote();
  // Takes out everything below the last LIR entry.
  void prune();

  const uint64_t lir_pages_, ghost_pages_;
  std::vector<Links> stack_;  // by node
};

}  // namespace sluice
