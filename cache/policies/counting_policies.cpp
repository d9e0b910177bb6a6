#include "cache/policies/counting_policies.h"

#include <algorithm>

namespace sluice {

bool PriorityPolicy::goesBefore(uint32_t a, uint32_t b) const {
  const Entry& one = entries_[a];
  const Entry& other = entries_[b];
  // Among equal priorities, the chunk that was requested longest ago goes first.
  return one.priority != other.priority ? one.priority < other.priority
                                        : one.last_request < other.last_request;
}

void PriorityPolicy::put(uint32_t index, size_t place) {
  heap_[place] = index;
  entries_[index].place = static_cast<uint32_t>(place);
}

void PriorityPolicy::rise(uint32_t index) {
  size_t place = entries_[index].place;
  for (; place > 0 && goesBefore(index, heap_[(place - 1) / 2]); place = (place - 1) / 2)
    put(heap_[(place - 1) / 2], place);
  put(index, place);
}

void PriorityPolicy::sink(uint32_t index) {
  size_t place = entries_[index].place;
  while (2 * place + 1 < heap_.size()) {
    size_t child = 2 * place + 1;
    if (child + 1 < heap_.size() && goesBefore(heap_[child + 1], heap_[child])) ++child;
    if (!goesBefore(heap_[child], index)) break;
    put(heap_[child], place);
    place = child;
  }
  put(index, place);
}

void PriorityPolicy::onHit(uint32_t index) {
  Entry& entry = entries_[index];
  entry.last_request = clock_;
  entry.priority = priorityOf(++entry.times, nodes_[index].weight);
  // Priorities fall only when L has fallen, after a pinned entry was passed over.
  rise(index);
  sink(index);
}

void PriorityPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) evictLowest();
  // Only after the evictions, or the next one would look at the same pinned entries again.
  takeBackPassed();
  admit(index, weight, 0);
  if (entries_.size() < nodes_.size()) entries_.resize(nodes_.size());
  entries_[index] = {priorityOf(1, weight), clock_, 1, static_cast<uint32_t>(heap_.size())};
  heap_.push_back(index);
  rise(index);
}

void PriorityPolicy::evictLowest() {
  while (nodes_[heap_.front()].pinned) {
    passed_.push_back(heap_.front());
    onRemoval(heap_.front());
  }
  const uint32_t victim = heap_.front();
  // GDSF's age L becomes the priority of the last victim.
  onEviction(entries_[victim].priority);
  evict(victim);
}

void PriorityPolicy::takeBackPassed() {
  for (const uint32_t index : passed_) {
    entries_[index].place = static_cast<uint32_t>(heap_.size());
    heap_.push_back(index);
    rise(index);
  }
  passed_.clear();
}

void PriorityPolicy::onRemoval(uint32_t index) {
  const size_t hole = entries_[index].place;
  const uint32_t last = heap_.back();
  heap_.pop_back();
  if (last == index) return;
  put(last, hole);
  // The last entry may belong above or below the hole.
  rise(last);
  sink(last);
}

}  // namespace sluice
