// PreparedTrace: a trace as flat arrays, made once and replayed under many configurations.
//
// The units, which every number of the simulator follows:
//   chunk request  one record: the renderer asks for a chunk, all of its pages or none.
//   page request   a chunk request of p pages is p page requests. With Granularity::kChunks (what
//                  the renderer does) they hit together or miss together, and replacement works on
//                  whole chunks. With kPages each of the p pages is an entry of its own, requested
//                  in order, which is how hardware that pages by itself would do it.
// A chunk's pages and bytes are those of its first record; later ones that differ are counted in
// `resized` and otherwise ignored, since a chunk id stands for the same voxels throughout.
// Plain data, constant after prepare().
#pragma once

#include <cstdint>
#include <vector>

#include "cache/policy.h"
#include "cache/trace.h"

namespace sluice {

enum class Granularity { kChunks, kPages };

struct PreparedTrace {
  uint64_t page_bytes = 4096;
  // One a request.
  std::vector<Key> keys;
  std::vector<uint32_t> visits;  // number of the cluster visit, rising; empty: one visit
  // One a key; both empty: one page each, page_bytes bytes, all needed.
  std::vector<uint32_t> weights;
  std::vector<LoadBytes> bytes;

  Key distinct = 0;             // keys are below
  uint64_t page_requests = 0;   // sum of the requests' weights
  uint64_t distinct_pages = 0;  // sum of the keys' weights: pages that must be loaded at least once
  uint32_t heaviest = 1;        // most pages of a key
  uint64_t resized = 0;         // records whose pages or bytes differ from the chunk's first

  uint32_t weightOf(Key key) const { return weights.empty() ? 1 : weights[key]; }
  LoadBytes bytesOf(Key key) const {
    return bytes.empty() ? LoadBytes{page_bytes, page_bytes, 0, 0} : bytes[key];
  }
};

// Throws Error when the trace has 2^32 - 16 requests or more (after splitting into pages).
PreparedTrace prepare(const Trace& trace, Granularity granularity = Granularity::kChunks);
// Requests of one page each. Requires: keys < 2^32 - 16.
PreparedTrace prepareUnit(std::vector<Key> keys, uint64_t page_bytes = 4096);

// For each request the position of the next request of the same key; kNever when there is none.
constexpr uint32_t kNever = UINT32_MAX;
std::vector<uint32_t> nextUses(const PreparedTrace& trace);

// `part` of `parts` equal shares of each count, such that the shares of 0..parts-1 sum to it.
// Requires: part < parts <= 2^31.
LoadBytes shareOf(const LoadBytes& bytes, uint64_t part, uint64_t parts);

}  // namespace sluice
