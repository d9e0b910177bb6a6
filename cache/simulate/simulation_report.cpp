#include "cache/simulate/simulation_report.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <utility>

#include "cache/simulate/page_extents.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

constexpr size_t kSamples = 400;
constexpr size_t kMostSizes = 20;

class ResidencyReplay {
 public:
  ResidencyReplay(const PreparedTrace& trace, const SimulationConfig& chosen)
      : trace_(trace),
        pins_(chosen.pin_clusters && !trace.visits.empty()),
        policy_(makePolicy(chosen.policy, chosen.pages, chosen.seed)),
        free_(chosen.pages),
        places_(trace.distinct),
        last_frame_(trace.distinct, kNoFrame) {
    policy_->reserve(trace.distinct);
  }

  void request(size_t i) {
    const Key key = trace_.keys[i];
    if (frame_ < trace_.frame_begins.size() && trace_.frame_begins[frame_] == i) {
      ++frame_;
      this_frame_ = 0;
    }
    if (pins_ && i > 0 && trace_.visits[i] != trace_.visits[i - 1]) policy_->unpinAll();
    evicted_.clear();
    const Outcome outcome = policy_->request(key, trace_.weightOf(key), evicted_);
    for (const Key gone : evicted_) {
      // Pages of this frame that it has evicted itself are no longer its residents.
      if (last_frame_[gone] == frame_) this_frame_ -= trace_.weightOf(gone);
      free_.giveBack(places_[gone]);
      places_[gone].clear();
      last_frame_[gone] = kNoFrame;
    }
    if (outcome == Outcome::kDoesNotFit) return;
    if (outcome == Outcome::kLoaded) places_[key] = free_.take(trace_.weightOf(key));
    if (last_frame_[key] != frame_) this_frame_ += trace_.weightOf(key);
    last_frame_[key] = static_cast<uint32_t>(frame_);
    if (pins_) policy_->pin(key);
  }

  SimulationReport::Sample sampleAfter(size_t requests) const {
    const uint64_t now = trace_.frame_begins.empty() ? 0 : this_frame_;
    return {requests, now, policy_->used() - now};
  }
  std::vector<ChunkId> firstPages() const {
    std::vector<ChunkId> map(std::min(policy_->capacity(), SimulationReport::kMostPagesShown),
                             TextureCache::kNoChunk);
    for (Key key = 0; key < trace_.distinct; ++key)
      for (const PageExtents::Extent& extent : places_[key])
        for (uint64_t page = extent.begin; page < std::min(extent.end, uint64_t{map.size()});
             ++page)
          map[page] = trace_.ids.empty() ? key : trace_.ids[key];
    return map;
  }

 private:
  static constexpr uint32_t kNoFrame = UINT32_MAX;

  const PreparedTrace& trace_;
  const bool pins_;
  const std::unique_ptr<Policy> policy_;
  PageExtents free_;
  std::vector<std::vector<PageExtents::Extent>> places_;  // by key; empty when not resident
  std::vector<uint32_t> last_frame_;                      // by key: in which it was requested last
  std::vector<Key> evicted_;
  size_t frame_ = 0;         // frames begun
  uint64_t this_frame_ = 0;  // pages of residents requested in the frame under way
};

}  // namespace

std::vector<std::pair<std::string, std::string>> factsOf(const PreparedTrace& trace,
                                                         const SimulationConfig& chosen) {
  return {
      {"Chunk requests", fmt::format("{}", trace.keys.size())},
      {"Page requests", fmt::format("{}", trace.page_requests)},
      {"Distinct chunks", fmt::format("{}", trace.distinct)},
      {"Distinct pages", fmt::format("{}", trace.distinct_pages)},
      {"Heaviest chunk", fmt::format("{} pages", trace.heaviest)},
      {"Page", formatBytes(trace.page_bytes)},
      {"Chosen", fmt::format("{}, {} pages ({})", name(chosen.policy), chosen.pages,
                             formatBytes(chosen.pages * trace.page_bytes))},
      {"Clusters pinned", chosen.pin_clusters && !trace.visits.empty() ? "yes" : "no"},
      {"Cost model",
       fmt::format("{:g} B/s, {:g} s a page, {:g} s a request", chosen.costs.bytes_per_second,
                   chosen.costs.seconds_per_page, chosen.costs.seconds_per_bind)},
  };
}

SimulationReport makeReport(const PreparedTrace& trace, std::string title,
                            std::vector<SimulationRow> rows, bool is_one_trace,
                            const SimulationConfig& chosen) {
  SimulationReport report;
  report.title = std::move(title);
  report.facts = factsOf(trace, chosen);
  report.page_bytes = trace.page_bytes;
  report.chosen_policy = chosen.policy;
  report.chosen_pages = chosen.pages;
  report.rows = std::move(rows);
  report.knows_frames = !trace.frame_begins.empty();
  if (is_one_trace) report.lru = lruCurve(trace);
  ResidencyReplay replay(trace, chosen);
  const size_t count = trace.keys.size();
  const size_t every = std::max<size_t>(1, count / kSamples);
  for (size_t i = 0; i < count; ++i) {
    replay.request(i);
    if (i % every == 0 || i + 1 == count) report.residency.push_back(replay.sampleAfter(i + 1));
  }
  report.page_map = replay.firstPages();
  return report;
}

std::vector<uint64_t> defaultSizes(const PreparedTrace& trace, uint64_t chosen_pages) {
  std::vector<uint64_t> sizes;
  // Sizes go from a cache that holds all down to one that holds the heaviest chunk alone.
  const uint64_t all = std::bit_ceil(std::max<uint64_t>(1, trace.distinct_pages));
  for (uint64_t pages = all; pages >= trace.heaviest && sizes.size() < kMostSizes; pages /= 2)
    sizes.push_back(pages);
  sizes.push_back(chosen_pages);
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  return sizes;
}

}  // namespace sluice
