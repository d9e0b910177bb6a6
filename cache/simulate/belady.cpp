#include "cache/simulate/belady.h"

#include <algorithm>

#include "src/base/error.h"

namespace sluice {

void BeladyPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) evict(takeFurthest());
  // Pinned entries were taken out to get at the others below them.
  for (const Use& use : pinned_uses_) {
    heap_.push_back(use);
    std::push_heap(heap_.begin(), heap_.end());
  }
  pinned_uses_.clear();
  admit(index, weight, 0);
  scheduleNext(index);
}

void BeladyPolicy::scheduleNext(uint32_t index) {
  SLUICE_CHECK_LE(clock_, uint64_t{next_uses_.size()});
  if (next_of_.size() < nodes_.size()) next_of_.resize(nodes_.size(), kNever);
  const uint32_t at = next_uses_[clock_ - 1];
  next_of_[index] = at;
  // Hits leave outdated entries at the bottom; sweep them before they outnumber the residents.
  if (heap_.size() > 2 * residents() + 1024) {
    std::erase_if(heap_, [&](const Use& use) { return !isCurrent(use); });
    std::make_heap(heap_.begin(), heap_.end());
  }
  heap_.push_back({at, index});
  std::push_heap(heap_.begin(), heap_.end());
}

uint32_t BeladyPolicy::takeFurthest() {
  while (true) {
    SLUICE_CHECK(!heap_.empty());
    std::pop_heap(heap_.begin(), heap_.end());
    const Use use = heap_.back();
    heap_.pop_back();
    // A hit has given the chunk a later use since, or it is gone.
    if (!isCurrent(use)) continue;
    if (!nodes_[use.index].pinned) return use.index;
    pinned_uses_.push_back(use);
  }
}

BeladyPages::BeladyPages(uint64_t capacity, const PreparedTrace& trace,
                         std::span<const uint32_t> next_uses)
    : capacity_(capacity),
      trace_(trace),
      next_uses_(next_uses),
      pages_in_(trace.distinct, 0),
      next_of_(trace.distinct, kNever) {}

BeladyPages::Answer BeladyPages::requestNext() {
  SLUICE_CHECK_LT(position_, trace_.keys.size());
  const Key key = trace_.keys[position_];
  const uint32_t next = next_uses_[position_];
  ++position_;
  const uint32_t weight = trace_.weightOf(key);
  if (weight > capacity_) return {false, weight};
  const uint32_t missing = weight - pages_in_[key];
  const uint32_t kept = pages_in_[key];
  pages_in_[key] = 0;  // so that making room does not evict the requested chunk
  makeRoom(missing);
  pages_in_[key] = kept + missing;
  used_ += missing;
  next_of_[key] = next;
  furthest_.push({next, key});
  return {true, missing};
}

void BeladyPages::makeRoom(uint64_t pages) {
  while (used_ + pages > capacity_) {
    SLUICE_CHECK(!furthest_.empty());
    const Use use = furthest_.top();
    if (pages_in_[use.key] == 0 || next_of_[use.key] != use.at) {
      furthest_.pop();
      continue;
    }
    // Only as many pages as are needed: the rest of the chunk stays and may still be hit.
    const auto gone =
        static_cast<uint32_t>(std::min<uint64_t>(pages_in_[use.key], used_ + pages - capacity_));
    pages_in_[use.key] -= gone;
    used_ -= gone;
    if (pages_in_[use.key] == 0) furthest_.pop();
  }
}

}  // namespace sluice
