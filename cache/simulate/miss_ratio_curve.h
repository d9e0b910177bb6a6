// Miss-ratio curves of LRU: misses at every cache size from one pass over the trace.
//
// lruCurve is exact at every size of at least the trace's heaviest chunk (see stack_distance.h), in
// O(log n) a request. ShardsEstimator (Waldspurger 2015) looks only at the chunks whose hash is
// below a threshold and scales their distances up: for traces too long for that. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <queue>
#include <unordered_map>
#include <utility>
#include <vector>

#include "cache/simulate/rank_index.h"
#include "cache/simulate/stack_distance.h"
#include "cache/trace/prepared_trace.h"

namespace sluice {

// A falling staircase: misses change only at the sizes listed.
struct MissRatioCurve {
  struct Step {
    uint64_t pages = 0;      // from this cache size on
    double page_misses = 0;  // in a trace of `requests` page requests; whole when exact
  };
  double requests = 0;      // page requests
  std::vector<Step> steps;  // ascending; the first is at 0 pages, at which everything misses
  // Mean over sizes of the miss ratio's expected absolute error; 0: exact.
  double stated_error = 0;

  // Page misses of LRU with `pages` pages.
  double missesAt(uint64_t pages) const;
  // The miss ratio, in [0, 1]; 1 for an empty trace.
  double missRatioAt(uint64_t pages) const { return requests > 0 ? missesAt(pages) / requests : 1; }
};

// Exact, of LRU at all sizes, by the stack distances of one pass (Mattson 1970).
MissRatioCurve lruCurve(const PreparedTrace& trace);

// Gathers weights of distances and sums them up into a curve.
class DistanceHistogram {
 public:
  // `distance`: the pages that a cache needs for the request to hit; `weight`: its page requests.
  void add(uint64_t distance, double weight) {
    if (distance < kDense) {
      if (distance >= dense_.size()) dense_.resize(std::min(kDense, 2 * distance + 64), 0);
      dense_[distance] += weight;
    } else {
      sparse_[distance] += weight;
    }
  }
  // A key's first request, which misses at every size.
  void addCold(double weight) { cold_ += weight; }
  MissRatioCurve curve() const;

 private:
  static constexpr uint64_t kDense = uint64_t{1} << 24;
  std::vector<double> dense_;
  std::map<uint64_t, double> sparse_;
  double cold_ = 0;
};

// SHARDS on a stream of requests, memory bounded by the number of chunks sampled.
//
// Its error: the sample consists of chunks. With n chunks sampled, the curve's mean absolute error
// over all sizes up to the number of distinct pages is expected below 2 / sqrt(n); stated_error
// holds this bound (8192 chunks: 0.022; on skewed traces we measure half of it and less). The error
// at a single size may be greater where the curve is steep. The difference between the requests
// seen and those that the sample stands for is added at the shortest distances (the paper's
// SHARDS-adj), since it comes from a few very hot chunks being in the sample or not.
class ShardsEstimator {
 public:
  // Fixed rate: chunks with probability `rate` in (0, 1]. Fixed size: at most `max_chunks` > 0,
  // the rate falls as needed. `seed` selects another sample.
  static ShardsEstimator fixedRate(double rate, uint64_t seed = 0);
  static ShardsEstimator fixedSize(size_t max_chunks, uint64_t seed = 0);

  // The first request of a chunk sets its pages. Requires: pages > 0.
  void request(uint64_t chunk, uint32_t pages);
  MissRatioCurve curve() const;
  size_t sampledChunks() const { return keys_.size(); }
  double rate() const;

 private:
  ShardsEstimator(uint64_t threshold, size_t max_chunks, uint64_t seed)
      : seed_(seed), max_chunks_(max_chunks), threshold_(threshold) {}
  void lowerThreshold();

  struct Sampled {
    Key key;
    uint32_t pages;
  };
  const uint64_t seed_;
  const size_t max_chunks_;                     // 0: any number
  uint64_t threshold_;                          // hashes below it are sampled, out of kHashes
  std::unordered_map<uint64_t, Sampled> keys_;  // by chunk
  std::priority_queue<std::pair<uint64_t, uint64_t>> by_hash_;  // hash, chunk; fixed size only
  std::vector<Key> free_keys_;
  StackDistances<WeightRank> distances_{0};
  DistanceHistogram histogram_;
  double seen_ = 0;         // page requests
  double represented_ = 0;  // page requests that the sampled ones stand for
};

}  // namespace sluice
