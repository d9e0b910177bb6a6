#include "cache/simulation_report.h"

#include <algorithm>
#include <bit>
#include <unordered_map>

#include "src/base/bytes.h"

namespace sluice {
namespace {

constexpr size_t kSamples = 400;
constexpr size_t kMostSizes = 20;

// Replays what the renderer would have asked and notes who is resident from when.
void replayChosen(const Trace& trace, const SimulationConfig& chosen, SimulationReport& report) {
  TextureCache cache(chosen.pages, trace.page_bytes,
                     makePolicy(chosen.policy, chosen.pages, chosen.seed));
  struct Resident {
    uint32_t pages, frame;
  };
  std::unordered_map<ChunkId, Resident> residents;
  uint64_t this_frame = 0;  // pages of residents requested in the frame under way
  uint32_t frame = 0;
  const TraceRecord* last = nullptr;
  std::unordered_map<ChunkId, uint32_t> first_pages;
  const size_t every = std::max<size_t>(1, trace.records.size() / kSamples);
  for (size_t i = 0; i < trace.records.size(); ++i) {
    const TraceRecord& r = trace.records[i];
    if (last == nullptr || last->frame != r.frame) {
      frame = r.frame;
      this_frame = 0;
    }
    if (last != nullptr && (last->frame != r.frame || last->cluster != r.cluster)) cache.unpinAll();
    last = &r;
    const uint32_t pages = first_pages.try_emplace(r.chunk, r.pages).first->second;
    const TextureCache::Answer answer = cache.request(r.chunk, pages, r.bytes.moved);
    for (const ChunkId gone : answer.evicted) {
      const auto found = residents.find(gone);
      if (found->second.frame == frame) this_frame -= found->second.pages;
      residents.erase(found);
    }
    if (answer.outcome != Outcome::kDoesNotFit) {
      const auto [at, is_new] = residents.try_emplace(r.chunk, Resident{pages, frame});
      // A frame number that comes again later would count twice; frames only rise in our traces.
      if (is_new || at->second.frame != frame) this_frame += pages;
      at->second.frame = frame;
      if (chosen.pin_clusters) cache.pin(r.chunk);
    }
    const uint64_t current = std::min(this_frame, cache.usedPages());
    if (i % every == 0 || i + 1 == trace.records.size())
      report.residency.push_back({i + 1, current, cache.usedPages() - current});
  }
  report.page_map = cache.pageMap();
}

}  // namespace

SimulationReport makeReport(const Trace& trace, std::string title,
                            std::span<const PolicyKind> policies,
                            std::span<const uint64_t> sizes_pages, const SimulationConfig& chosen) {
  const PreparedTrace prepared = prepare(trace);
  SimulationReport report;
  report.title = std::move(title);
  report.page_bytes = trace.page_bytes;
  report.chosen_policy = chosen.policy;
  report.chosen_pages = chosen.pages;
  report.rows = simulateTable(prepared, policies, sizes_pages, chosen);
  report.lru = lruCurve(prepared);
  replayChosen(trace, chosen, report);
  report.facts = {
      {"Chunk requests", fmt::format("{}", trace.records.size())},
      {"Page requests", fmt::format("{}", prepared.page_requests)},
      {"Distinct chunks", fmt::format("{}", prepared.distinct)},
      {"Distinct pages", fmt::format("{}", prepared.distinct_pages)},
      {"Heaviest chunk", fmt::format("{} pages", prepared.heaviest)},
      {"Page", formatBytes(trace.page_bytes)},
      {"Chosen", fmt::format("{}, {} pages ({})", name(chosen.policy), chosen.pages,
                             formatBytes(chosen.pages * trace.page_bytes))},
      {"Clusters pinned", chosen.pin_clusters ? "yes" : "no"},
      {"Cost model",
       fmt::format("{:g} B/s, {:g} s a page, {:g} s a bind", chosen.costs.bytes_per_second,
                   chosen.costs.seconds_per_page, chosen.costs.seconds_per_bind)},
  };
  return report;
}

std::vector<uint64_t> defaultSizes(const PreparedTrace& trace, uint64_t chosen_pages) {
  std::vector<uint64_t> sizes;
  const uint64_t all = std::bit_ceil(std::max<uint64_t>(1, trace.distinct_pages));
  for (uint64_t pages = all; pages >= trace.heaviest && sizes.size() < kMostSizes; pages /= 2)
    sizes.push_back(pages);
  sizes.push_back(chosen_pages);
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  return sizes;
}

}  // namespace sluice
