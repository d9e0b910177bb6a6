// KeyTable: numbers 64-bit chunk ids 0, 1, 2, ... in order of first sight, so that everything else
// in `cache/` works on flat arrays. Open addressing with linear probing; ids are never removed.
// One thread.
#pragma once

#include <cstdint>
#include <utility>

#include "cache/policies/flat_array.h"
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
  // All ids, by key.
  const FlatArray<uint64_t>& ids() const { return ids_; }
  // kNone when the id has not been seen.
  uint32_t find(uint64_t id) const { return slots_.empty() ? kNone : slots_[slotOf(id)].key; }
  // The id's number, a new one when it has none. Requires: fewer than 2^32 - 16 ids.
  uint32_t insert(uint64_t id) { return insertNoted(id).key; }
  // The same with a number stored next to it for the caller's use, 0 at first. The reference is
  // good until the next insertion.
  struct Noted {
    uint32_t key;
    uint32_t& note;
  };
  Noted insertNoted(uint64_t id) {
    if ((ids_.size() + 1) * 2 > slots_.size()) grow();
    Slot& slot = slots_[slotOf(id)];
    if (slot.key == kNone) {
      SLUICE_CHECK_LT(ids_.size(), size_t{kNone - 16});
      slot = {id, static_cast<uint32_t>(ids_.size()), 0};
      ids_.push_back(id);
    }
    return {slot.key, slot.note};
  }
  // A hint that `id` will be asked for soon. Always inlined: gcc takes a function that does nothing
  // but this for one that does nothing, and leaves the call out.
  [[gnu::always_inline]] void prefetch(uint64_t id) const {
    if (!slots_.empty()) __builtin_prefetch(&slots_[mixBits(id) & (slots_.size() - 1)]);
  }

 private:
  // The id next to its key, so that a look-up reads one place in memory.
  struct Slot {
    uint64_t id = 0;
    uint32_t key = kNone;  // kNone: empty
    uint32_t note = 0;
  };

  // The slot of `id`, or the empty slot where it belongs.
  size_t slotOf(uint64_t id) const {
    const size_t mask = slots_.size() - 1;
    size_t i = mixBits(id) & mask;
    while (slots_[i].key != kNone && slots_[i].id != id) i = (i + 1) & mask;
    return i;
  }
  void grow() {
    const FlatArray<Slot> before = std::move(slots_);
    slots_.assign(before.empty() ? 64 : before.size() * 2, Slot{});
    for (const Slot& slot : before)
      if (slot.key != kNone) slots_[slotOf(slot.id)] = slot;
  }

  FlatArray<Slot> slots_;  // a power of two, at most half full
  FlatArray<uint64_t> ids_;
};

}  // namespace sluice
