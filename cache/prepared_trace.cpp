#include "cache/prepared_trace.h"

#include <algorithm>
#include <utility>

#include "cache/key_table.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMaxRequests = UINT32_MAX - 16;

PreparedTrace splitIntoPages(const PreparedTrace& chunks) {
  if (chunks.page_requests >= kMaxRequests || chunks.distinct_pages >= kMaxRequests)
    fail(
        "the trace makes {} page requests, more than the 2^32 - 17 that can be replayed page by "
        "page; replay whole chunks",
        chunks.page_requests);
  PreparedTrace out;
  out.page_bytes = chunks.page_bytes;
  out.resized = chunks.resized;
  std::vector<Key> first_page(chunks.distinct);
  for (Key key = 0; key < chunks.distinct; ++key) {
    first_page[key] = out.distinct;
    const uint32_t pages = chunks.weightOf(key);
    for (uint32_t p = 0; p < pages; ++p)
      out.bytes.push_back(shareOf(chunks.bytesOf(key), p, pages));
    out.distinct += pages;
  }
  out.weights.assign(out.distinct, 1);
  out.keys.reserve(chunks.page_requests);
  for (size_t i = 0; i < chunks.keys.size(); ++i) {
    const Key key = chunks.keys[i];
    for (uint32_t p = 0; p < chunks.weightOf(key); ++p) {
      out.keys.push_back(first_page[key] + p);
      out.visits.push_back(chunks.visits[i]);
    }
  }
  out.page_requests = out.keys.size();
  out.distinct_pages = out.distinct;
  return out;
}

}  // namespace

PreparedTrace prepare(const Trace& trace, Granularity granularity) {
  if (trace.records.size() >= kMaxRequests)
    fail("the trace has {} records, more than the 2^32 - 17 that can be replayed at once; cut it",
         trace.records.size());
  PreparedTrace out;
  out.page_bytes = trace.page_bytes;
  out.keys.reserve(trace.records.size());
  out.visits.reserve(trace.records.size());
  KeyTable table;
  uint32_t visit = 0;
  const TraceRecord* last = nullptr;
  for (const TraceRecord& r : trace.records) {
    const Key key = table.insert(r.chunk);
    if (key == out.distinct) {
      ++out.distinct;
      out.weights.push_back(r.pages);
      out.bytes.push_back(r.bytes);
      out.distinct_pages += r.pages;
      out.heaviest = std::max(out.heaviest, r.pages);
    } else if (out.weights[key] != r.pages || out.bytes[key] != r.bytes) {
      ++out.resized;
    }
    if (last != nullptr && (last->cluster != r.cluster || last->frame != r.frame)) ++visit;
    last = &r;
    out.keys.push_back(key);
    out.visits.push_back(visit);
    out.page_requests += out.weights[key];
  }
  return granularity == Granularity::kChunks ? out : splitIntoPages(out);
}

PreparedTrace prepareUnit(std::vector<Key> keys, uint64_t page_bytes) {
  PreparedTrace out;
  out.page_bytes = page_bytes;
  std::vector<bool> seen;
  for (const Key key : keys) {
    if (key >= out.distinct) out.distinct = key + 1;
    if (key >= seen.size()) seen.resize(std::max<size_t>(key + 1, seen.size() * 2), false);
    if (!seen[key]) ++out.distinct_pages;
    seen[key] = true;
  }
  out.page_requests = keys.size();
  out.keys = std::move(keys);
  return out;
}

std::vector<uint32_t> nextUses(const PreparedTrace& trace) {
  std::vector<uint32_t> next(trace.keys.size());
  std::vector<uint32_t> seen_at(trace.distinct, kNever);
  for (size_t i = trace.keys.size(); i-- > 0;) {
    next[i] = seen_at[trace.keys[i]];
    seen_at[trace.keys[i]] = static_cast<uint32_t>(i);
  }
  return next;
}

LoadBytes shareOf(const LoadBytes& bytes, uint64_t part, uint64_t parts) {
  const auto share = [&](uint64_t count) {
    // count * n / parts, rounded down, without leaving 64 bits.
    const auto upTo = [&](uint64_t n) { return count / parts * n + count % parts * n / parts; };
    return upTo(part + 1) - upTo(part);
  };
  // The rest is split on its own and `moved` summed up, so that the causes of a share add up too.
  LoadBytes out{0, share(bytes.needed), share(bytes.extended), share(bytes.empty)};
  out.moved = out.needed + out.extended + out.empty + share(bytes.rounding());
  return out;
}

}  // namespace sluice
