#include "cache/simulate/simulator.h"

#include <algorithm>
#include <memory>

#include "cache/policies/flat_array.h"
#include "cache/simulate/belady.h"
#include "cache/simulate/lru_replay.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// How far ahead of the replay entries and then their neighbors are fetched.
constexpr size_t kEntryAhead = 24;
constexpr size_t kNeighborsAhead = 12;

// `count` loads and evictions at once, for pages: a chunk may have 2^31.
void countLoads(CacheCounters& c, uint64_t count, uint64_t bytes_each, bool were_resident_before) {
  c.loads += count;
  c.redundant_loads += were_resident_before ? count : 0;
  c.loaded_bytes += count * bytes_each;
  c.resident += count;
  c.peak_resident = std::max(c.peak_resident, c.resident);
  c.current_bytes += count * bytes_each;
  c.peak_bytes = std::max(c.peak_bytes, c.current_bytes);
}
void countEvictions(CacheCounters& c, uint64_t count, uint64_t bytes_each) {
  c.evictions += count;
  c.evicted_bytes += count * bytes_each;
  c.resident -= count;
  c.current_bytes -= count * bytes_each;
}

void addLoads(LoadBytes& sum, const LoadBytes& load, uint64_t times) {
  sum.moved += times * load.moved;
  sum.needed += times * load.needed;
  sum.extended += times * load.extended;
  sum.empty += times * load.empty;
}

class Replay {
 public:
  Replay(const PreparedTrace& trace, const SimulationConfig& config, SimulationRow& row)
      : trace_(trace), config_(config), row_(row), loads_of_(trace.distinct, 0) {}

  void run(Policy& policy) {
    policy.reserve(trace_.distinct);
    const size_t count = trace_.keys.size();
    const Key* keys = trace_.keys.data();
    const bool pins = config_.pin_clusters && !trace_.visits.empty();
    for (size_t i = 0; i < count; ++i) {
      // Traces have more chunks than caches of the processor, and their order is not one that it
      // foresees.
      if (i + kEntryAhead < count) {
        policy.prefetchEntry(keys[i + kEntryAhead]);
        trace_.prefetchWeight(keys[i + kEntryAhead]);
        policy.prefetchNeighbors(keys[i + kNeighborsAhead]);
      }
      if (pins && i > 0 && trace_.visits[i] != trace_.visits[i - 1]) policy.unpinAll();
      const Outcome outcome = policy.request(keys[i], trace_.weightOf(keys[i]), evicted_);
      if (outcome != Outcome::kHit) countMiss(keys[i], outcome, policy.used(), policy.residents());
      if (pins) policy.pin(keys[i]);
    }
    finish(policy.used(), policy.residents());
  }

  void run(LruReplay& lru) {
    const size_t count = trace_.keys.size();
    const Key* keys = trace_.keys.data();
    for (size_t i = 0; i < count; ++i) {
      if (i + kEntryAhead < count) {
        lru.prefetch(keys[i + kEntryAhead]);
        trace_.prefetchWeight(keys[i + kEntryAhead]);
      }
      const Outcome outcome = lru.request(keys[i]);
      if (outcome != Outcome::kHit) countMiss(keys[i], outcome, lru.used(), lru.residents());
    }
    finish(lru.used(), lru.residents());
  }

  void run(BeladyPages& belady) {
    CacheCounters& c = row_.chunks;
    for (const Key key : trace_.keys) {
      const uint64_t used_before = belady.used();
      const BeladyPages::Answer answer = belady.requestNext();
      const uint32_t hit = trace_.weightOf(key) - answer.pages_missing;
      // Here pages are the unit, since chunks may be resident in part.
      c.requests += trace_.weightOf(key);
      c.hits += hit;
      c.misses += answer.pages_missing;
      row_.misses += answer.pages_missing;
      if (!answer.fits) {
        c.failures += answer.pages_missing;
        countFailure(key);
      } else if (answer.pages_missing > 0) {
        const uint64_t gone = used_before + answer.pages_missing - belady.used();
        countPartialLoad(key, answer.pages_missing, gone);
      }
    }
  }

 private:
  // Counts a miss, after which `used` pages and `residents` entries are resident. The cost of loads
  // is summed up at the end, so that a miss touches one word of memory here.
  void countMiss(Key key, Outcome outcome, uint64_t used, uint64_t residents) {
    evicted_.clear();
    if (outcome == Outcome::kDoesNotFit) {
      ++row_.chunks.failures;
      countFailure(key);
      return;
    }
    ++loads_of_[key];
    peak_used_ = std::max(peak_used_, used);
    row_.chunks.peak_resident = std::max(row_.chunks.peak_resident, residents);
  }

  void countFailure(Key key) {
    const LoadBytes load = trace_.bytesOf(key);
    ++row_.failures;
    row_.failed_pages += trace_.weightOf(key);
    row_.failed_bytes += load.moved;
    addLoads(row_.bytes, load, 1);
  }

  void finish(uint64_t used, uint64_t residents) {
    CacheCounters& c = row_.chunks;
    for (Key key = 0; key < trace_.distinct; ++key) {
      const uint64_t loads = loads_of_[key];
      if (loads == 0) continue;
      const LoadBytes load = trace_.bytesOf(key);
      c.loads += loads;
      // All loads of a chunk but its first one.
      c.redundant_loads += loads - 1;
      c.uploaded_bytes += loads * load.moved;
      row_.pages_loaded += loads * trace_.weightOf(key);
      addLoads(row_.bytes, load, loads);
    }
    row_.misses = row_.pages_loaded + row_.failed_pages;
    c.requests = trace_.keys.size();
    c.misses = c.loads + c.failures;
    c.hits = c.requests - c.misses;
    c.loaded_bytes = row_.pages_loaded * trace_.page_bytes;
    c.resident = residents;
    c.current_bytes = used * trace_.page_bytes;
    // Whatever was loaded and is not there has been evicted.
    c.evictions = c.loads - c.resident;
    c.evicted_bytes = c.loaded_bytes - c.current_bytes;
    c.peak_bytes = peak_used_ * trace_.page_bytes;
  }

  // `missing` of the chunk's pages after `gone` pages of others went. A page moves its share of
  // the chunk's bytes; which pages are missing does not matter, so the first shares stand for them.
  void countPartialLoad(Key key, uint32_t missing, uint64_t gone) {
    CacheCounters& c = row_.chunks;
    countEvictions(c, gone, trace_.page_bytes);
    countLoads(c, missing, trace_.page_bytes, loads_of_[key] > 0);
    const LoadBytes load = firstShares(trace_.bytesOf(key), missing, trace_.weightOf(key));
    c.uploaded_bytes += load.moved;
    addLoads(row_.bytes, load, 1);
    ++loads_of_[key];
    row_.pages_loaded += missing;
  }

  const PreparedTrace& trace_;
  const SimulationConfig& config_;
  SimulationRow& row_;
  uint64_t peak_used_ = 0;        // pages
  FlatArray<uint32_t> loads_of_;  // by key
  std::vector<Key> evicted_;      // for the request under way
};

uint64_t lruMisses(const PreparedTrace& trace, uint64_t pages) {
  SimulationConfig lru;
  lru.pages = pages;
  return simulate(trace, lru, 0).misses;
}

}  // namespace

SimulationRow simulate(const PreparedTrace& trace, const SimulationConfig& config,
                       std::optional<uint64_t> lru_misses) {
  const bool pins = config.pin_clusters && !trace.visits.empty();
  const bool is_plain_lru = config.policy == PolicyKind::kLru && !pins;
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
  } else if (is_plain_lru) {
    LruReplay lru(trace, config.pages);
    replay.run(lru);
  } else {
    replay.run(*makePolicy(config.policy, config.pages, config.seed));
  }
  row.hits = row.requests - row.misses;
  // The causes of misses (Hill 1987): capacity misses are those of LRU in addition to the
  // compulsory ones, and conflict misses the difference to LRU.
  const uint64_t lru = is_plain_lru ? row.misses
                       : lru_misses ? *lru_misses
                                    : lruMisses(trace, config.pages);
  row.compulsory = static_cast<int64_t>(trace.distinct_pages);
  row.capacity = static_cast<int64_t>(lru) - row.compulsory;
  row.conflict = static_cast<int64_t>(row.misses) - static_cast<int64_t>(lru);
  row.modelled_seconds =
      config.costs.seconds(row.bytes.moved, row.pages_loaded + row.failed_pages, trace.keys.size());
  return row;
}

std::vector<SimulationRow> simulateTable(const PreparedTrace& trace,
                                         std::span<const PolicyKind> policies,
                                         std::span<const uint64_t> sizes_pages,
                                         SimulationConfig config) {
  std::vector<SimulationRow> rows;
  for (const uint64_t pages : sizes_pages) {
    config.pages = pages;
    std::optional<uint64_t> lru;  // the first row finds it out
    for (const PolicyKind policy : policies) {
      config.policy = policy;
      rows.push_back(simulate(trace, config, lru));
      // LRU's misses follow from any row: its own less the conflict misses.
      lru = static_cast<uint64_t>(static_cast<int64_t>(rows.back().misses) - rows.back().conflict);
    }
  }
  return rows;
}

void add(SimulationRow& sum, const SimulationRow& more) {
  sum.pages += more.pages;
  sum.requests += more.requests;
  sum.hits += more.hits;
  sum.misses += more.misses;
  sum.compulsory += more.compulsory;
  sum.capacity += more.capacity;
  sum.conflict += more.conflict;
  sum.chunks += more.chunks;
  sum.pages_loaded += more.pages_loaded;
  sum.bytes.moved += more.bytes.moved;
  sum.bytes.needed += more.bytes.needed;
  sum.bytes.extended += more.bytes.extended;
  sum.bytes.empty += more.bytes.empty;
  sum.failures += more.failures;
  sum.failed_pages += more.failed_pages;
  sum.failed_bytes += more.failed_bytes;
  sum.modelled_seconds += more.modelled_seconds;
  if (sum.planned_pages && more.planned_pages) *sum.planned_pages += *more.planned_pages;
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
  if (b.moved != row.chunks.uploaded_bytes + row.failed_bytes)
    return fmt::format("moved {} != uploaded {} + failed {}", b.moved, row.chunks.uploaded_bytes,
                       row.failed_bytes);
  return row.chunks.brokenIdentity();
}

}  // namespace sluice
