#include "cache/simulate/miss_ratio_curve.h"

#include <algorithm>
#include <cmath>

#include "cache/policies/key_table.h"

namespace sluice {
namespace {

constexpr uint64_t kHashes = uint64_t{1} << 32;
constexpr size_t kPositionAhead = 32;
constexpr size_t kRankAhead = 12;

// Calls record(distance, weight) for each request.
template <class Rank, class Record>
void forEachDistance(const PreparedTrace& trace, Record&& record) {
  StackDistances<Rank> distances(trace.distinct);
  const size_t count = trace.keys.size();
  for (size_t i = 0; i < count; ++i) {
    // A distance depends on two reads of memory that are far apart, the second of which needs the
    // first one's result.
    if (i + kPositionAhead < count) {
      distances.prefetchPosition(trace.keys[i + kPositionAhead]);
      distances.prefetchRank(trace.keys[i + kRankAhead]);
    }
    const uint32_t weight = Rank::kWeighted ? trace.weightOf(trace.keys[i]) : 1;
    record(distances.request(trace.keys[i], weight), weight);
  }
}

constexpr uint64_t kColdDistance = StackDistances<UnitRank>::kCold;

// Distances are at most the number of distinct keys: small counts in one array.
MissRatioCurve unitCurve(const PreparedTrace& trace) {
  FlatArray<uint32_t> counts(size_t{trace.distinct} + 1, 0);
  uint32_t cold = 0;
  forEachDistance<UnitRank>(trace, [&](uint64_t distance, uint32_t) {
    ++(distance == kColdDistance ? cold : counts[distance]);
  });
  DistanceHistogram histogram;
  histogram.addCold(cold);
  for (size_t distance = 0; distance < counts.size(); ++distance) {
    if (counts[distance] != 0) histogram.add(distance, counts[distance]);
  }
  return histogram.curve();
}

MissRatioCurve weightedCurve(const PreparedTrace& trace) {
  DistanceHistogram histogram;
  forEachDistance<WeightRank>(trace, [&](uint64_t distance, uint32_t weight) {
    if (distance == kColdDistance) {
      histogram.addCold(weight);
    } else {
      histogram.add(distance, weight);
    }
  });
  return histogram.curve();
}

}  // namespace

double MissRatioCurve::missesAt(uint64_t pages) const {
  const auto after = std::upper_bound(steps.begin(), steps.end(), pages,
                                      [](uint64_t p, const Step& s) { return p < s.pages; });
  return after == steps.begin() ? requests : std::prev(after)->page_misses;
}

MissRatioCurve lruCurve(const PreparedTrace& trace) {
  return trace.heaviest == 1 ? unitCurve(trace) : weightedCurve(trace);
}

MissRatioCurve DistanceHistogram::curve() const {
  MissRatioCurve out;
  out.requests = cold_;
  for (const double weight : dense_) out.requests += weight;
  for (const auto& [distance, weight] : sparse_) out.requests += weight;
  out.steps.push_back({0, out.requests});
  double left = out.requests;
  const auto addStep = [&](uint64_t distance, double weight) {
    left -= weight;
    if (distance == 0) {
      // A distance of 0 is a hit in a cache of any size.
      out.steps.back().page_misses = left;
    } else if (weight != 0) {
      out.steps.push_back({distance, left});
    }
  };
  for (size_t distance = 0; distance < dense_.size(); ++distance) {
    if (dense_[distance] != 0) addStep(distance, dense_[distance]);
  }
  for (const auto& [distance, weight] : sparse_) addStep(distance, weight);
  return out;
}

ShardsEstimator ShardsEstimator::fixedRate(double rate, uint64_t seed) {
  SLUICE_CHECK(rate > 0 && rate <= 1);
  const auto threshold = static_cast<uint64_t>(rate * static_cast<double>(kHashes));
  return {std::max<uint64_t>(1, threshold), 0, seed};
}

ShardsEstimator ShardsEstimator::fixedSize(size_t max_chunks, uint64_t seed) {
  SLUICE_CHECK_LT(size_t{0}, max_chunks);
  return {kHashes, max_chunks, seed};
}

double ShardsEstimator::rate() const {
  return static_cast<double>(threshold_) / static_cast<double>(kHashes);
}

void ShardsEstimator::request(uint64_t chunk, uint32_t pages) {
  seen_ += pages;
  // Sampling by the chunk's hash takes all requests of a chunk or none (SHARDS, Waldspurger et al.
  // 2015).
  const uint64_t hash = mixBits(mixBits(chunk) ^ seed_) >> 32;
  if (hash >= threshold_) return;
  auto found = keys_.find(chunk);
  if (found == keys_.end()) {
    Key key = static_cast<Key>(keys_.size());
    if (!free_keys_.empty()) {
      key = free_keys_.back();
      free_keys_.pop_back();
    }
    found = keys_.emplace(chunk, Sampled{key, pages}).first;
    if (max_chunks_ != 0) by_hash_.emplace(hash, chunk);
  }
  const auto [key, weight] = found->second;
  const uint64_t distance = distances_.request(key, weight);
  const double stands_for = weight / rate();
  represented_ += stands_for;
  if (distance == distances_.kCold) {
    histogram_.addCold(stands_for);
  } else {
    // Distances in the sample are shorter by the rate; the chunk's own pages are not.
    const double others = static_cast<double>(distance - weight) / rate();
    histogram_.add(static_cast<uint64_t>(std::llround(others)) + weight, stands_for);
  }
  if (max_chunks_ != 0 && keys_.size() > max_chunks_) lowerThreshold();
}

// Drops the chunks with the largest hash; their counts stay, at the rate of that time.
void ShardsEstimator::lowerThreshold() {
  threshold_ = std::max<uint64_t>(1, by_hash_.top().first);
  while (!by_hash_.empty() && by_hash_.top().first >= threshold_) {
    const auto dropped = keys_.find(by_hash_.top().second);
    distances_.forget(dropped->second.key);
    free_keys_.push_back(dropped->second.key);
    keys_.erase(dropped);
    by_hash_.pop();
  }
}

MissRatioCurve ShardsEstimator::curve() const {
  DistanceHistogram adjusted = histogram_;
  // SHARDS-adj: requests that the sample has too few or too many of are counted as hits, as those
  // of hot chunks are.
  adjusted.add(0, seen_ - represented_);
  MissRatioCurve out = adjusted.curve();
  out.requests = seen_;
  for (MissRatioCurve::Step& step : out.steps)
    step.page_misses = std::clamp(step.page_misses, 0.0, seen_);
  out.stated_error =
      rate() >= 1 ? 0 : 2 / std::sqrt(static_cast<double>(std::max<size_t>(1, keys_.size())));
  return out;
}

}  // namespace sluice
