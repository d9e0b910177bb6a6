// The replacement policies written down line by line from their papers, for entries of one page and
// without pins, with the library's lists and maps. They count the misses of long traces.
#pragma once

#include <cstdint>
#include <span>

#include "cache/policies/policy.h"

namespace sluice::test {

// Misses of the requests with `capacity` pages. Requires: one of kLru, kFifo, kClock, kSieve,
// kS3Fifo, kArc, kTwoQ, kBelady; capacity > 0.
uint64_t paperMisses(PolicyKind kind, uint64_t capacity, std::span<const Key> requests);

}  // namespace sluice::test
