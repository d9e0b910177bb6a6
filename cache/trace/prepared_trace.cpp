#include "cache/trace/prepared_trace.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kMaxRequests = UINT32_MAX - 16;

constexpr uint64_t kMostBytes = uint64_t{1} << 63;
// Records whose chunks are fetched ahead: as many as a core can have in flight.
constexpr size_t kAhead = 16;

// A digest of a chunk's sizes, stored next to its key, so that a record whose sizes are the chunk's
// needs no other look at memory. Two sizes have the same with a chance of 2^-32.
uint32_t shapeOf(const TraceRecord& r) {
  const uint64_t mixed = mixBits(
      r.bytes.moved + mixBits(r.pages + mixBits(r.bytes.needed ^ (r.bytes.extended << 21) ^
                                                (r.bytes.empty << 42) ^ (r.bytes.empty >> 22))));
  return static_cast<uint32_t>(mixed >> 32);
}

}  // namespace

TracePreparer::TracePreparer(uint64_t page_bytes, bool carries_clusters)
    : carries_clusters_(carries_clusters) {
  out_.page_bytes = page_bytes;
}

void TracePreparer::add(const TraceRecord& record) {
  batch_[in_batch_++] = record;
  if (in_batch_ == kBatch) takeBatch();
}

void TracePreparer::takeBatch() {
  if (out_.keys.size() + in_batch_ >= kMaxRequests)
    fail("the trace has more than the 2^32 - 17 records that can be replayed at once; cut it");
  // A key table of a large trace does not fit into the caches, so a batch's entries are fetched
  // before they are looked at.
  for (size_t i = 0; i < std::min(kAhead, in_batch_); ++i) table_.prefetch(batch_[i].chunk);
  for (size_t i = 0; i < in_batch_; ++i) {
    if (i + kAhead < in_batch_) table_.prefetch(batch_[i + kAhead].chunk);
    take(batch_[i]);
  }
  in_batch_ = 0;
  // Checked after each batch: its records have at most 2^40 bytes each, so that the sum cannot wrap
  // in between.
  if (moved_bytes_ >= kMostBytes)
    fail("the trace's loads are 2^63 bytes or more, which is more than can be counted; cut it");
}

void TracePreparer::take(const TraceRecord& r) {
  const auto [key, shape] = table_.insertNoted(r.chunk);
  uint64_t moved = r.bytes.moved;
  uint32_t pages = r.pages;
  if (key == out_.distinct) {
    ++out_.distinct;
    shape = shapeOf(r);
    out_.weights.push_back(r.pages);
    out_.bytes.push_back(r.bytes);
    out_.distinct_pages += r.pages;
    out_.heaviest = std::max(out_.heaviest, r.pages);
    is_uniform_ = is_uniform_ && r.pages == 1 && r.bytes == out_.bytes.front();
    // A chunk keeps its first size, which the cache model takes to be constant.
  } else if (shape != shapeOf(r)) {
    ++out_.resized;
    pages = out_.weights[key];
    moved = out_.bytes[key].moved;
  }
  if (carries_clusters_) beginVisit(r);
  out_.keys.push_back(key);
  out_.page_requests += pages;
  moved_bytes_ += moved;
}

// Notes the visit, and the begin of a frame.
void TracePreparer::beginVisit(const TraceRecord& r) {
  const bool is_first = out_.keys.empty();
  const bool new_frame = is_first || r.frame != last_frame_;
  if (!is_first && (new_frame || r.cluster != last_cluster_)) ++visit_;
  if (new_frame) out_.frame_begins.push_back(static_cast<uint32_t>(out_.keys.size()));
  last_cluster_ = r.cluster;
  last_frame_ = r.frame;
  out_.visits.push_back(visit_);
}

PreparedTrace TracePreparer::finish() {
  takeBatch();
  if (out_.page_requests >= kMostBytes / out_.page_bytes)
    fail(
        "the trace's {} page requests of {} B are 2^63 bytes or more, which is more than can be "
        "counted; cut it",
        out_.page_requests, out_.page_bytes);
  out_.ids = table_.ids();
  // One record of sizes for all, so that replaying a large trace reads less memory.
  if (is_uniform_ && !out_.bytes.empty()) {
    out_.bytes_of_all = out_.bytes.front();
    out_.bytes = {};
    out_.weights = {};
  }
  return std::move(out_);
}

PreparedTrace prepare(const Trace& trace) {
  TracePreparer preparer(trace.page_bytes, trace.carries_clusters);
  for (const TraceRecord& r : trace.records) preparer.add(r);
  return preparer.finish();
}

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
    if (!chunks.ids.empty()) out.ids.insert(out.ids.end(), pages, chunks.ids[key]);
    out.distinct += pages;
  }
  out.weights.assign(out.distinct, 1);
  out.keys.reserve(chunks.page_requests);
  size_t frame = 0;
  for (size_t i = 0; i < chunks.keys.size(); ++i) {
    if (frame < chunks.frame_begins.size() && chunks.frame_begins[frame] == i) {
      out.frame_begins.push_back(static_cast<uint32_t>(out.keys.size()));
      ++frame;
    }
    const Key key = chunks.keys[i];
    for (uint32_t p = 0; p < chunks.weightOf(key); ++p) {
      out.keys.push_back(first_page[key] + p);
      if (!chunks.visits.empty()) out.visits.push_back(chunks.visits[i]);
    }
  }
  out.page_requests = out.keys.size();
  out.distinct_pages = out.distinct;
  return out;
}

PreparedTrace prepareUnit(const std::vector<Key>& keys) {
  PreparedTrace out;
  out.bytes_of_all = {out.page_bytes, out.page_bytes, 0, 0};
  std::vector<bool> seen;
  for (const Key key : keys) {
    if (key >= out.distinct) out.distinct = key + 1;
    if (key >= seen.size()) seen.resize(std::max<size_t>(key + 1, seen.size() * 2), false);
    if (!seen[key]) ++out.distinct_pages;
    seen[key] = true;
  }
  out.page_requests = keys.size();
  out.keys.assign(keys.begin(), keys.end());
  return out;
}

std::vector<uint32_t> nextUses(const PreparedTrace& trace) {
  std::vector<uint32_t> next(trace.keys.size());
  std::vector<uint32_t> seen_at(trace.distinct, kNever);
  // Backwards, so that the next use of each key is the one seen last.
  for (size_t i = trace.keys.size(); i-- > 0;) {
    next[i] = seen_at[trace.keys[i]];
    seen_at[trace.keys[i]] = static_cast<uint32_t>(i);
  }
  return next;
}

LoadBytes firstShares(const LoadBytes& bytes, uint64_t count, uint64_t parts) {
  // total * count / parts, rounded down, without leaving 64 bits.
  const auto upTo = [&](uint64_t total) {
    return total / parts * count + total % parts * count / parts;
  };
  // The rest is split on its own and `moved` summed up, so that the causes of a share add up too.
  LoadBytes out{0, upTo(bytes.needed), upTo(bytes.extended), upTo(bytes.empty)};
  out.moved = out.needed + out.extended + out.empty + upTo(bytes.rounding());
  return out;
}

LoadBytes shareOf(const LoadBytes& bytes, uint64_t part, uint64_t parts) {
  const LoadBytes before = firstShares(bytes, part, parts);
  const LoadBytes with = firstShares(bytes, part + 1, parts);
  return {with.moved - before.moved, with.needed - before.needed, with.extended - before.extended,
          with.empty - before.empty};
}

}  // namespace sluice
