#include "cache/simulate/prefetch.h"

#include <array>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "cache/trace/prepared_trace.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr std::array kModelNames{std::pair{PrefetchModel::kNextCluster, "next-cluster"},
                                 std::pair{PrefetchModel::kNextTimeStep, "next-time-step"},
                                 std::pair{PrefetchModel::kLastOrder, "last-order"}};

// Requests [begin, end) for one cluster of one frame.
struct Visit {
  size_t begin, end;
  uint32_t cluster, frame;
};

std::vector<Visit> visitsOf(const Trace& trace) {
  std::vector<Visit> visits;
  for (size_t i = 0; i < trace.records.size(); ++i) {
    const TraceRecord& r = trace.records[i];
    if (visits.empty() || visits.back().cluster != r.cluster || visits.back().frame != r.frame)
      visits.push_back({i, i, r.cluster, r.frame});
    visits.back().end = i + 1;
  }
  return visits;
}

// The visit to load ahead after each visit; -1 for none.
std::vector<int64_t> predictions(const std::vector<Visit>& visits, PrefetchModel model) {
  std::map<std::pair<uint32_t, uint32_t>, int64_t> visit_of;  // (frame, cluster) -> first visit
  for (size_t v = 0; v < visits.size(); ++v)
    visit_of.try_emplace({visits[v].frame, visits[v].cluster}, static_cast<int64_t>(v));
  const auto find = [&](uint64_t frame, uint32_t cluster) {
    const auto found = visit_of.find({static_cast<uint32_t>(frame), cluster});
    return frame > UINT32_MAX || found == visit_of.end() ? -1 : found->second;
  };
  const auto following = [&](int64_t v) {
    const auto next = static_cast<size_t>(v + 1);
    return v >= 0 && next < visits.size() && visits[next].frame == visits[next - 1].frame ? v + 1
                                                                                          : -1;
  };
  std::vector<int64_t> out(visits.size(), -1);
  for (size_t v = 0; v < visits.size(); ++v) {
    const Visit& visit = visits[v];
    if (model == PrefetchModel::kNextCluster) {
      out[v] = following(static_cast<int64_t>(v));
    } else if (model == PrefetchModel::kNextTimeStep) {
      out[v] = find(uint64_t{visit.frame} + 1, visit.cluster);
    } else if (visit.frame > 0) {
      out[v] = following(find(visit.frame - 1, visit.cluster));
    }
  }
  return out;
}

class PrefetchRun {
 public:
  PrefetchRun(const PreparedTrace& trace, const PrefetchConfig& config)
      : trace_(trace),
        cache_(makePolicy(config.policy, config.pages, config.seed)),
        shadow_(makePolicy(config.policy, config.pages, config.seed)),
        pins_(config.pin_clusters),
        unused_(trace.distinct, false) {}

  void demand(const Visit& visit) {
    // A cluster's chunks are pinned until the next one is drawn.
    cache_->unpinAll();
    shadow_->unpinAll();
    for (size_t i = visit.begin; i < visit.end; ++i) {
      const Key key = trace_.keys[i];
      const uint32_t pages = trace_.weightOf(key);
      result_.requests += pages;
      const bool hit = request(key) == Outcome::kHit;
      std::vector<Key> ignored;
      const bool shadow_hit = shadow_->request(key, pages, ignored) == Outcome::kHit;
      if (pins_) shadow_->pin(key);
      // The first hit alone is owed to loading ahead.
      if (hit && unused_[key]) result_.used += pages;
      unused_[key] = false;
      result_.misses += hit ? 0 : pages;
      result_.misses_without += shadow_hit ? 0 : pages;
      // A miss that the cache without loading ahead would not have had.
      result_.polluted += !hit && shadow_hit ? pages : 0;
      if (pins_) cache_->pin(key);
    }
  }

  void loadAhead(const Visit& visit) {
    for (size_t i = visit.begin; i < visit.end; ++i) {
      const Key key = trace_.keys[i];
      // A chunk that does not fit beside the pinned ones is not loaded ahead.
      if (cache_->contains(key) || request(key) != Outcome::kLoaded) continue;
      unused_[key] = true;
      result_.prefetched += trace_.weightOf(key);
    }
  }
  const PrefetchResult& result() const { return result_; }

 private:
  Outcome request(Key key) {
    evicted_.clear();
    const Outcome outcome = cache_->request(key, trace_.weightOf(key), evicted_);
    for (const Key gone : evicted_) unused_[gone] = false;
    return outcome;
  }

  const PreparedTrace& trace_;
  const std::unique_ptr<Policy> cache_;
  const std::unique_ptr<Policy> shadow_;  // the same without prefetching
  const bool pins_;
  std::vector<bool> unused_;  // by key: loaded ahead and not requested since
  std::vector<Key> evicted_;
  PrefetchResult result_;
};

}  // namespace

std::string_view name(PrefetchModel model) {
  for (const auto& [m, text] : kModelNames) {
    if (m == model) return text;
  }
  return "?";
}

PrefetchResult simulatePrefetch(const Trace& trace, const PrefetchConfig& config) {
  SLUICE_CHECK(trace.carries_clusters);
  const PreparedTrace prepared = prepare(trace);
  const std::vector<Visit> visits = visitsOf(trace);
  const std::vector<int64_t> ahead = predictions(visits, config.model);
  PrefetchRun run(prepared, config);
  for (size_t v = 0; v < visits.size(); ++v) {
    run.demand(visits[v]);
    if (ahead[v] >= 0) run.loadAhead(visits[static_cast<size_t>(ahead[v])]);
  }
  return run.result();
}

}  // namespace sluice
