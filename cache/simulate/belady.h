// Belady's optimum, knowing the whole trace: no policy can do better.
//
// BeladyPolicy ("belady", by request) evicts the entry whose next request is furthest away. When
// all entries weigh the same, no policy that loads on every miss has fewer misses. When they do
// not, the least number of misses is a knapsack-like problem (NP-hard) and this is a heuristic.
//
// BeladyPages ("belady-pages", by byte) may keep parts of chunks: on a request it loads the pages
// that are missing and evicts, page by page, from the chunks requested furthest in the future. The
// chunk requested must be resident as a whole afterwards. No policy under that rule moves fewer
// pages, whole-chunk policies with any weights included, so it is the bound that the tables show;
// in bytes too when every page moves the same number of bytes, as page-aligned chunks do.
// Both are the same when every entry is one page. One thread.
#pragma once

#include <queue>
#include <span>
#include <vector>

#include "cache/policies/policy.h"
#include "cache/trace/prepared_trace.h"

namespace sluice {

class BeladyPolicy final : public Policy {
 public:
  // The n-th request made must be the n-th of the trace that `next_uses` is of; it must outlive
  // the policy. Requires: no request beyond it.
  BeladyPolicy(uint64_t capacity, std::span<const uint32_t> next_uses)
      : Policy(capacity), next_uses_(next_uses) {}

 private:
  void onHit(uint32_t index) override { scheduleNext(index); }
  void onMiss(uint32_t index, uint32_t weight) override;
  void scheduleNext(uint32_t index);
  uint32_t takeFurthest();

  struct Use {
    uint32_t at, index;
    friend bool operator<(const Use& a, const Use& b) {
      return a.at != b.at ? a.at < b.at : a.index < b.index;
    }
  };
  bool isCurrent(const Use& use) const {
    return nodes_[use.index].resident && next_of_[use.index] == use.at;
  }

  const std::span<const uint32_t> next_uses_;
  std::vector<uint32_t> next_of_;  // by node
  std::vector<Use> heap_;          // furthest first; entries that are no longer current are dropped
  std::vector<Use> pinned_uses_;   // set aside while looking for a victim
};

class BeladyPages {
 public:
  // The optimum described above; `trace` must outlive it. Requires: capacity > 0.
  BeladyPages(uint64_t capacity, const PreparedTrace& trace, std::span<const uint32_t> next_uses);

  struct Answer {
    bool fits = true;
    uint32_t pages_missing = 0;  // loaded now, or, when it does not fit, its whole weight
  };
  // The next request of the trace. Requires: there is one.
  Answer requestNext();
  uint64_t used() const { return used_; }

 private:
  struct Use {
    uint32_t at;
    Key key;
    friend bool operator<(const Use& a, const Use& b) {
      return a.at != b.at ? a.at < b.at : a.key < b.key;
    }
  };
  void makeRoom(uint64_t pages);

  const uint64_t capacity_;
  const PreparedTrace& trace_;
  const std::span<const uint32_t> next_uses_;
  size_t position_ = 0;
  uint64_t used_ = 0;
  std::vector<uint32_t> pages_in_;  // by key
  std::vector<uint32_t> next_of_;   // by key
  std::priority_queue<Use> furthest_;
};

}  // namespace sluice
