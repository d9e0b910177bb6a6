// KeyTable: numbers 64-bit chunk ids 0, 1, 2, ... in order of first sight, so that everything else
// in `cache/` works on flat arrays. Open addressing with linear probing; ids are never removed.
// One thread.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/error.h"

namespace sluice {

// A well-mixed 64-bit hash of an id (the finalizer of splitmix64).
constexpr uint64_t mixBits(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

class KeyTable {
 public:
  static constexpr uint32_t kNone = UINT32_MAX;

  uint32_t size() const { return static_cast<uint32_t>(ids_.size()); }
  // Requires: key < size().
  uint64_t idOf(uint32_t key) const { return ids_[key]; }
  // kNone when the id has not been seen.
  uint32_t find(uint64_t id) const { return slots_.empty() ? kNone : slots_[slotOf(id)]; }
  // The id's number, a new one when it has none. Requires: fewer than 2^32 - 16 ids.
  uint32_t insert(uint64_t id) {
    if ((ids_.size() + 1) * 2 > slots_.size()) grow();
    uint32_t& slot = slots_[slotOf(id)];
    if (slot == kNone) {
      SLUICE_CHECK_LT(ids_.size(), size_t{kNone - 16});
      slot = static_cast<uint32_t>(ids_.size());
      ids_.push_back(id);
    }
    return slot;
  }

 private:
  // Where `id` is, or the empty slot where it belongs.
  size_t slotOf(uint64_t id) const {
    const size_t mask = slots_.size() - 1;
    size_t i = mixBits(id) & mask;
    while (slots_[i] != kNone && ids_[slots_[i]] != id) i = (i + 1) & mask;
    return i;
  }
  void grow() {
    slots_.assign(slots_.empty() ? 64 : slots_.size() * 2, kNone);
    for (uint32_t key = 0; key < ids_.size(); ++key) slots_[slotOf(ids_[key])] = key;
  }

  std::vector<uint32_t> slots_;  // a power of two, at most half full
  std::vector<uint64_t> ids_;
};

}  // namespace sluice
