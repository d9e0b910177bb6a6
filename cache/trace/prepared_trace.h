// PreparedTrace: a trace as flat arrays, made once and replayed under many configurations.
//
// The units, which every number of the simulator follows:
//   chunk request  one record: the renderer asks for a chunk, all of its pages or none.
//   page request   a chunk request of p pages is p page requests. As in the renderer they hit
//                  together or miss together, and replacement works on whole chunks. After
//                  splitIntoPages() each of the p pages is an entry of its own, requested in order,
//                  as hardware that pages by itself would do it.
// The first record of a chunk sets its pages and bytes; later ones that differ are counted in
// `resized` and otherwise ignored, since a chunk id stands for the same voxels throughout.
// Plain data, constant after prepare().
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "cache/policies/flat_array.h"
#include "cache/policies/key_table.h"
#include "cache/policies/policy.h"
#include "cache/trace/trace.h"

namespace sluice {

struct PreparedTrace {
  uint64_t page_bytes = 4096;
  // The key of each request.
  FlatArray<Key> keys;
  FlatArray<uint32_t> visits;  // number of the cluster visit, rising; empty: no clusters known
  // The weight of each key; both empty: every key has one page and `bytes_of_all`.
  FlatArray<uint32_t> weights;
  FlatArray<LoadBytes> bytes;
  LoadBytes bytes_of_all;
  FlatArray<uint64_t> ids;  // the chunk's in the trace; empty: the key itself
  // Positions of the requests that begin a frame; empty: no frames known.
  std::vector<uint32_t> frame_begins;

  Key distinct = 0;             // keys are below
  uint64_t page_requests = 0;   // sum of the requests' weights
  uint64_t distinct_pages = 0;  // sum of the keys' weights: pages that must be loaded at least once
  uint32_t heaviest = 1;        // most pages of a key
  uint64_t resized = 0;         // records whose pages or bytes differ from the chunk's first

  uint32_t weightOf(Key key) const { return weights.empty() ? 1 : weights[key]; }
  LoadBytes bytesOf(Key key) const { return bytes.empty() ? bytes_of_all : bytes[key]; }
  // A hint that weightOf will be asked for soon.
  void prefetchWeight(Key key) const {
    if (!weights.empty()) __builtin_prefetch(&weights[key]);
  }
};

// Makes a prepared trace of chunk requests from records that come one by one, so that no more than
// the flat arrays need to be in memory. One thread.
class TracePreparer {
 public:
  // `carries_clusters`: whether the records' clusters and frames mean something.
  TracePreparer(uint64_t page_bytes, bool carries_clusters);
  // Throws Error beyond 2^32 - 17 records, and if all their loads are 2^63 bytes or more.
  void add(const TraceRecord& record);
  PreparedTrace finish();

 private:
  // Records are taken a batch at a time, so that their look-ups are fetched together.
  static constexpr size_t kBatch = 64;
  void takeBatch();
  void take(const TraceRecord& record);
  void beginVisit(const TraceRecord& record);

  const bool carries_clusters_;
  std::array<TraceRecord, kBatch> batch_;
  size_t in_batch_ = 0;
  KeyTable table_;
  PreparedTrace out_;
  uint64_t moved_bytes_ = 0;  // if every request moved its chunk
  bool is_uniform_ = true;    // all keys so far have one page and the same bytes
  uint32_t visit_ = 0, last_cluster_ = 0, last_frame_ = 0;
};

// Throws Error as TracePreparer does.
PreparedTrace prepare(const Trace& trace);
// The same trace with each page an entry of its own. Takes some 8 bytes a page request. Throws
// Error when there are 2^32 - 17 pages or more to split into.
PreparedTrace splitIntoPages(const PreparedTrace& chunks);
// Requests of one page of 4 KiB each. Requires: keys < 2^32 - 16.
PreparedTrace prepareUnit(const std::vector<Key>& keys);

// The position of the next request of the same key, for each request; kNever if there is none.
constexpr uint32_t kNever = UINT32_MAX;
std::vector<uint32_t> nextUses(const PreparedTrace& trace);

// `part` of `parts` equal shares of each count, such that the shares of 0..parts-1 sum to it.
// Requires: part < parts <= 2^31; count <= parts.
LoadBytes shareOf(const LoadBytes& bytes, uint64_t part, uint64_t parts);
// The sum of the first `count` of them.
LoadBytes firstShares(const LoadBytes& bytes, uint64_t count, uint64_t parts);

}  // namespace sluice
