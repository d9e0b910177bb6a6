#include "cache/policies/segmented_policies.h"

#include <algorithm>

namespace sluice {
namespace {

constexpr uint64_t kWindowShare = 100;     // a page in so many
constexpr uint64_t kRequestsOfAPage = 10;  // until counts halve
constexpr uint8_t kMostTimes = 15;

uint64_t windowPages(uint64_t capacity) {
  return std::max<uint64_t>(1, capacity / kWindowShare);
}

}  // namespace

SegmentedPolicy::SegmentedPolicy(uint64_t capacity, uint64_t segmented_pages)
    : Policy(capacity), protected_pages_(segmented_pages - (segmented_pages + 4) / 5) {}

void SegmentedPolicy::onHit(uint32_t index) {
  if (nodes_[index].list != kProbation) return touch(index);
  unlink(index);
  pushHead(kProtected, index);
  // An entry that leaves the protected part gets another chance in probation.
  while (listWeight(kProtected) > protected_pages_) {
    const uint32_t oldest = tail(kProtected);
    unlink(oldest);
    pushHead(kProbation, oldest);
  }
}

uint32_t SegmentedPolicy::segmentedVictim() const {
  for (const uint32_t list : {kProbation, kProtected}) {
    const uint32_t oldest = oldestUnpinned(list);
    if (oldest != list) return oldest;
  }
  return kNone;
}

void SlruPolicy::onMiss(uint32_t index, uint32_t weight) {
  while (isFull(weight)) evict(segmentedVictim());
  admit(index, weight, kProbation);
}

WTinyLfuPolicy::WTinyLfuPolicy(uint64_t capacity)
    : SegmentedPolicy(capacity, capacity - windowPages(capacity)),
      window_pages_(windowPages(capacity)),
      sample_(kRequestsOfAPage * capacity) {}

uint8_t WTinyLfuPolicy::timesOf(uint32_t index) const {
  if (index >= counts_.size()) return 0;
  const Count& known = counts_[index];
  // More halvings than bits leave nothing, and a shift by more would be undefined.
  const uint64_t halvings = std::min<uint64_t>(halvings_ - known.halvings, 8);
  return static_cast<uint8_t>(known.times >> halvings);
}

// A key's count is halved when it is looked at, so that a halving of all costs nothing.
void WTinyLfuPolicy::count(uint32_t index) {
  if (counts_.size() < nodes_.size()) counts_.resize(nodes_.size());
  const uint8_t times = timesOf(index);
  counts_[index] = {halvings_, std::min<uint8_t>(kMostTimes, times + 1)};
  if (++counted_ < sample_) return;
  // It halves at the same time as the counts.
  counted_ = sample_ / 2;
  ++halvings_;
}

void WTinyLfuPolicy::onHit(uint32_t index) {
  count(index);
  SegmentedPolicy::onHit(index);
}

void WTinyLfuPolicy::toMain(uint32_t index) {
  unlink(index);
  pushHead(kProbation, index);
}

void WTinyLfuPolicy::onMiss(uint32_t index, uint32_t weight) {
  count(index);
  while (isFull(weight)) {
    const uint32_t of_window = oldestUnpinned(kWindow);
    const bool window_can = of_window != kWindow;
    const uint32_t of_main = segmentedVictim();
    const bool contested = window_can && isWindowOver(weight);
    // The entry that was requested less often leaves; the window's on a tie, since it has proved
    // less.
    if (of_main == kNone || (contested && timesOf(of_window) <= timesOf(of_main))) {
      evict(of_window);
    } else {
      evict(of_main);
      if (contested) toMain(of_window);
    }
  }
  // There is room: entries that exceed the window enter the main part without a contest.
  while (isWindowOver(weight) && !isEmpty(kWindow)) toMain(tail(kWindow));
  admit(index, weight, kWindow);
}

}  // namespace sluice
