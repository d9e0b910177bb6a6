// CacheCounters: the accounting of a cache, the same at every level (volume buffer, texture buffer,
// texture cache): one struct, one definition a line, each event counted by one member function.
//
// Plain values: the cache that owns them calls the members under its own mutex and copies the
// struct out for readers. These identities hold while no load is under way (design point 4):
//   requests = hits + misses
//   misses = loads + coalesced + failures
//   resident = resident at the last reset + loads - evictions, in entries and in bytes; in bytes
//   also - packed + unpacked, if a level compresses its entries
// brokenIdentity() names the one that does not hold. A read-ahead is a request like any other: it
// counts its own miss and load, and the later request that it serves counts a hit (or coalesced).
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>

namespace sluice {

struct CacheCounters {
  // Events since the last reset().
  uint64_t requests = 0;         // someone asked for an entry
  uint64_t hits = 0;             // and it was resident
  uint64_t misses = 0;           // and it was not
  uint64_t coalesced = 0;        // misses that wait for a load already begun by another thread
  uint64_t failures = 0;         // misses whose load ended in an error or that cannot fit
  uint64_t loads = 0;            // misses whose load brought the entry in
  uint64_t redundant_loads = 0;  // loads of an entry that had been resident before, as remembered
  uint64_t evictions = 0;        // entries that went, for room or because they became invalid
  uint64_t loaded_bytes = 0;     // by loads, in the unit of current_bytes
  uint64_t evicted_bytes = 0;    // by evictions, in the same unit
  uint64_t packs = 0;            // residents that were compressed in place
  uint64_t unpacks = 0;          // and made whole again for a hit
  uint64_t packed_bytes = 0;     // given back to the budget by packing
  uint64_t unpacked_bytes = 0;   // taken from the budget again by unpacking
  // The cost of the loads by kind. A level leaves at 0 the kinds that it does not do.
  uint64_t stored_bytes = 0;    // taken from files, compressed if they are
  uint64_t decoded_bytes = 0;   // written as voxels into this level
  uint64_t uploaded_bytes = 0;  // handed to the device's upload call

  // Occupancy: outlives reset().
  uint64_t resident = 0;       // entries now
  uint64_t peak_resident = 0;  // most entries at once since construction
  uint64_t current_bytes = 0;  // bytes of the entries that are resident now
  uint64_t peak_bytes = 0;     // most at once since construction
  uint64_t budget_bytes = 0;   // limit of current_bytes; 0: none
  // The occupancy when reset() was last called, so that the identities hold after it too.
  uint64_t resident_at_reset = 0;
  uint64_t bytes_at_reset = 0;

  void countHit() { ++requests, ++hits; }
  // Found absent. Exactly one of countCoalesced, countFailure, countLoad follows.
  void countMiss() { ++requests, ++misses; }
  void countCoalesced() { ++coalesced; }
  void countFailure() { ++failures; }
  // The entry is in and takes `bytes` of the budget. Call after the evictions that made room, so
  // that the peak never exceeds what was there at once.
  void countLoad(uint64_t bytes, bool was_resident_before) {
    ++loads;
    redundant_loads += was_resident_before ? 1 : 0;
    loaded_bytes += bytes;
    peak_resident = std::max(peak_resident, ++resident);
    current_bytes += bytes;
    peak_bytes = std::max(peak_bytes, current_bytes);
  }
  // Requires: an entry of these bytes is resident.
  void countEviction(uint64_t bytes) {
    ++evictions;
    evicted_bytes += bytes;
    --resident;
    current_bytes -= bytes;
  }

  // A resident entry now takes `to` bytes of the budget instead of `from`, which are more.
  void countPack(uint64_t from, uint64_t to) {
    ++packs;
    packed_bytes += from - to;
    current_bytes -= from - to;
  }
  // The way back, from fewer to more.
  void countUnpack(uint64_t from, uint64_t to) {
    ++unpacks;
    unpacked_bytes += to - from;
    current_bytes += to - from;
    peak_bytes = std::max(peak_bytes, current_bytes);
  }

  // Those of another cache too. Peaks become the sums of both, of which less may have been there at
  // once.
  CacheCounters& operator+=(const CacheCounters& more) {
    constexpr uint64_t CacheCounters::*kAll[] = {&CacheCounters::requests,
                                                 &CacheCounters::hits,
                                                 &CacheCounters::misses,
                                                 &CacheCounters::coalesced,
                                                 &CacheCounters::failures,
                                                 &CacheCounters::loads,
                                                 &CacheCounters::redundant_loads,
                                                 &CacheCounters::evictions,
                                                 &CacheCounters::loaded_bytes,
                                                 &CacheCounters::evicted_bytes,
                                                 &CacheCounters::packs,
                                                 &CacheCounters::unpacks,
                                                 &CacheCounters::packed_bytes,
                                                 &CacheCounters::unpacked_bytes,
                                                 &CacheCounters::stored_bytes,
                                                 &CacheCounters::decoded_bytes,
                                                 &CacheCounters::uploaded_bytes,
                                                 &CacheCounters::resident,
                                                 &CacheCounters::peak_resident,
                                                 &CacheCounters::current_bytes,
                                                 &CacheCounters::peak_bytes,
                                                 &CacheCounters::budget_bytes,
                                                 &CacheCounters::resident_at_reset,
                                                 &CacheCounters::bytes_at_reset};
    for (uint64_t CacheCounters::*field : kAll) this->*field += more.*field;
    return *this;
  }

  // Zeroes events, never occupancy.
  void reset() {
    CacheCounters kept;
    kept.resident = kept.resident_at_reset = resident;
    kept.peak_resident = peak_resident;
    kept.current_bytes = kept.bytes_at_reset = current_bytes;
    kept.peak_bytes = peak_bytes;
    kept.budget_bytes = budget_bytes;
    *this = kept;
  }

  // Empty if every identity holds; otherwise one line that names the broken one, with the values.
  // Requires: no load is under way.
  std::string brokenIdentity() const {
    if (requests != hits + misses)
      return fmt::format("requests {} != hits {} + misses {}", requests, hits, misses);
    if (misses != loads + coalesced + failures)
      return fmt::format("misses {} != loads {} + coalesced {} + failures {}", misses, loads,
                         coalesced, failures);
    if (resident_at_reset + loads != evictions + resident)
      return fmt::format("resident before {} + loads {} - evictions {} != resident {}",
                         resident_at_reset, loads, evictions, resident);
    if (bytes_at_reset + loaded_bytes + unpacked_bytes !=
        evicted_bytes + packed_bytes + current_bytes)
      return fmt::format(
          "bytes before {} + loaded {} - evicted {} - packed {} + unpacked {} != current {}",
          bytes_at_reset, loaded_bytes, evicted_bytes, packed_bytes, unpacked_bytes, current_bytes);
    if (redundant_loads > loads)
      return fmt::format("redundant loads {} > loads {}", redundant_loads, loads);
    if (current_bytes > peak_bytes || resident > peak_resident)
      return fmt::format("current {} B in {} > peak {} B in {}", current_bytes, resident,
                         peak_bytes, peak_resident);
    if (budget_bytes != 0 && peak_bytes > budget_bytes)
      return fmt::format("peak {} B > budget {} B", peak_bytes, budget_bytes);
    return {};
  }
};

}  // namespace sluice
