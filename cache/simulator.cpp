#include "cache/simulator.h"

#include <memory>

#include "cache/belady.h"
#include "cache/lru_replay.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// How far ahead of the replay entries and then their neighbors are fetched.
constexpr size_t kEntryAhead = 24;
constexpr size_t kNeighborsAhead = 12;

void addLoad(LoadBytes& sum, const LoadBytes& load) {
  sum.moved += load.moved;
  sum.needed += load.needed;
  sum.extended += load.extended;
  sum.empty += load.empty;
}

class Replay {
 public:
  Replay(const PreparedTrace& trace, const SimulationConfig& config, SimulationRow& row)
      : trace_(trace), config_(config), row_(row), was_resident_(trace.distinct, false) {}

  void run(Policy& policy) {
    policy.reserve(trace_.distinct);
    const size_t count = trace_.keys.size();
    const Key* keys = trace_.keys.data();
    uint64_t hits = 0;
    for (size_t i = 0; i < count; ++i) {
      if (i + kEntryAhead < count) {
        policy.prefetchEntry(keys[i + kEntryAhead]);
        policy.prefetchNeighbors(keys[i + kNeighborsAhead]);
      }
      if (config_.pin_clusters && i > 0 && visitOf(i) != visitOf(i - 1)) policy.unpinAll();
      const Outcome outcome = policy.request(keys[i], trace_.weightOf(keys[i]), evicted_);
      if (outcome == Outcome::kHit) {
        ++hits;
      } else {
        countMiss(keys[i], outcome);
      }
      if (config_.pin_clusters) policy.pin(keys[i]);
    }
    row_.chunks.requests += hits;
    row_.chunks.hits += hits;
  }

  void run(LruReplay& lru) {
    const size_t count = trace_.keys.size();
    const Key* keys = trace_.keys.data();
    CacheCounters& c = row_.chunks;
    for (size_t i = 0; i < count; ++i) {
      if (i + kEntryAhead < count) lru.prefetch(keys[i + kEntryAhead]);
      const Outcome outcome = lru.request(keys[i]);
      if (outcome == Outcome::kHit) continue;
      was_resident_[keys[i]] = lru.wasRedundant();
      const uint64_t evicted_before = c.evictions;
      const uint64_t bytes_before = c.evicted_bytes;
      c.evictions = lru.evictions();
      c.evicted_bytes = lru.evictedWeight() * trace_.page_bytes;
      c.resident -= c.evictions - evicted_before;
      c.current_bytes -= c.evicted_bytes - bytes_before;
      countMiss(keys[i], outcome);
    }
    c.hits = count - c.misses;
    c.requests = count;
  }

  void run(BeladyPages& belady) {
    CacheCounters& c = row_.chunks;
    for (const Key key : trace_.keys) {
      const uint64_t used_before = belady.used();
      const BeladyPages::Answer answer = belady.requestNext();
      const uint32_t hit = trace_.weightOf(key) - answer.pages_missing;
      c.requests += trace_.weightOf(key);
      c.hits += hit;
      c.misses += answer.pages_missing;
      row_.misses += answer.pages_missing;
      if (!answer.fits) {
        c.failures += answer.pages_missing;
        ++not_fitting_;
      } else if (answer.pages_missing > 0) {
        const uint64_t gone = used_before + answer.pages_missing - belady.used();
        countPartialLoad(key, answer.pages_missing, gone);
      }
    }
  }

  // Chunk requests that could not be met.
  uint64_t notFitting() const { return not_fitting_; }

 private:
  uint32_t visitOf(size_t i) const { return trace_.visits.empty() ? 0 : trace_.visits[i]; }

  void countMiss(Key key, Outcome outcome) {
    CacheCounters& c = row_.chunks;
    const uint32_t weight = trace_.weightOf(key);
    row_.misses += weight;
    c.countMiss();
    if (outcome == Outcome::kDoesNotFit) {
      c.countFailure();
      ++not_fitting_;
      return;
    }
    for (const Key gone : evicted_) c.countEviction(trace_.weightOf(gone) * trace_.page_bytes);
    evicted_.clear();
    const LoadBytes load = trace_.bytesOf(key);
    c.countLoad(uint64_t{weight} * trace_.page_bytes, was_resident_[key]);
    c.uploaded_bytes += load.moved;
    was_resident_[key] = true;
    row_.pages_loaded += weight;
    addLoad(row_.bytes, load);
  }

  // `missing` of the chunk's pages after `gone` pages of others went. A page moves its share of
  // the chunk's bytes; which pages are missing does not matter, so the first shares stand for them.
  void countPartialLoad(Key key, uint32_t missing, uint64_t gone) {
    CacheCounters& c = row_.chunks;
    for (uint64_t i = 0; i < gone; ++i) c.countEviction(trace_.page_bytes);
    for (uint32_t page = 0; page < missing; ++page) {
      c.countLoad(trace_.page_bytes, was_resident_[key]);
      const LoadBytes load = shareOf(trace_.bytesOf(key), page, trace_.weightOf(key));
      c.uploaded_bytes += load.moved;
      addLoad(row_.bytes, load);
    }
    was_resident_[key] = true;
    row_.pages_loaded += missing;
  }

  const PreparedTrace& trace_;
  const SimulationConfig& config_;
  SimulationRow& row_;
  uint64_t not_fitting_ = 0;
  std::vector<bool> was_resident_;  // by key
  std::vector<Key> evicted_;        // of the request under way
};

uint64_t lruMisses(const PreparedTrace& trace, uint64_t pages) {
  SimulationConfig lru;
  lru.pages = pages;
  return simulate(trace, lru, 0).misses;
}

}  // namespace

SimulationRow simulate(const PreparedTrace& trace, const SimulationConfig& config,
                       std::optional<uint64_t> lru_misses) {
  SimulationRow row;
  row.policy = config.policy;
  row.pages = config.pages;
  row.requests = trace.page_requests;
  row.chunks.budget_bytes = config.pages * trace.page_bytes;
  Replay replay(trace, config, row);
  if (config.policy == PolicyKind::kBelady || config.policy == PolicyKind::kBeladyPages) {
    const std::vector<uint32_t> next_uses = nextUses(trace);
    if (config.policy == PolicyKind::kBelady) {
      BeladyPolicy belady(config.pages, next_uses);
      replay.run(belady);
    } else {
      BeladyPages belady(config.pages, trace, next_uses);
      replay.run(belady);
    }
  } else if (config.policy == PolicyKind::kLru && !config.pin_clusters) {
    LruReplay lru(trace, config.pages);
    replay.run(lru);
  } else {
    replay.run(*makePolicy(config.policy, config.pages, config.seed));
  }
  row.hits = row.requests - row.misses;
  row.binds = trace.keys.size() - replay.notFitting();
  const bool is_plain_lru = config.policy == PolicyKind::kLru && !config.pin_clusters;
  const uint64_t lru = is_plain_lru ? row.misses
                       : lru_misses ? *lru_misses
                                    : lruMisses(trace, config.pages);
  row.compulsory = static_cast<int64_t>(trace.distinct_pages);
  row.capacity = static_cast<int64_t>(lru) - row.compulsory;
  row.conflict = static_cast<int64_t>(row.misses) - static_cast<int64_t>(lru);
  row.modelled_seconds = config.costs.seconds(row.bytes.moved, row.pages_loaded, row.binds);
  return row;
}

std::vector<SimulationRow> simulateTable(const PreparedTrace& trace,
                                         std::span<const PolicyKind> policies,
                                         std::span<const uint64_t> sizes_pages,
                                         SimulationConfig config) {
  std::vector<SimulationRow> rows;
  for (const uint64_t pages : sizes_pages) {
    config.pages = pages;
    const uint64_t lru = lruMisses(trace, pages);
    for (const PolicyKind policy : policies) {
      config.policy = policy;
      rows.push_back(simulate(trace, config, lru));
    }
  }
  return rows;
}

std::string brokenIdentity(const SimulationRow& row) {
  if (row.requests != row.hits + row.misses)
    return fmt::format("requests {} != hits {} + misses {}", row.requests, row.hits, row.misses);
  if (row.compulsory + row.capacity + row.conflict != static_cast<int64_t>(row.misses))
    return fmt::format("compulsory {} + capacity {} + conflict {} != misses {}", row.compulsory,
                       row.capacity, row.conflict, row.misses);
  if (row.capacity < 0) return fmt::format("capacity misses {} < 0", row.capacity);
  if (row.pages_loaded > row.misses)
    return fmt::format("pages loaded {} > pages missed {}", row.pages_loaded, row.misses);
  const LoadBytes& b = row.bytes;
  if (b.needed + b.extended + b.empty > b.moved)
    return fmt::format("needed {} + extended {} + empty {} > moved {}", b.needed, b.extended,
                       b.empty, b.moved);
  if (b.moved != row.chunks.uploaded_bytes)
    return fmt::format("moved {} != uploaded {}", b.moved, row.chunks.uploaded_bytes);
  return row.chunks.brokenIdentity();
}

}  // namespace sluice
