// TextureCache: level 4 as a model. It decides which chunk is loaded into which pages and which
// chunks are evicted for it; a device does exactly that (design point 5), so that simulated and
// real I/O are equal byte for byte.
//
// A chunk takes any free pages, the lowest numbers first. A page is the unit of placement and of
// transfer, so nothing fragments outside a page. Residency lasts across clusters and frames until
// eviction. Deterministic: the same requests give the same pages. One thread (the one that draws).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "cache/policies/policy.h"
#include "src/base/threads/counters.h"

namespace sluice {

using ChunkId = uint64_t;

class TextureCache {
 public:
  struct Answer {
    Outcome outcome = Outcome::kDoesNotFit;
    bool was_resident_before = false;  // for a load: it is redundant
    std::span<const uint32_t> pages;   // the chunk's pages; empty when it does not fit
    std::span<const ChunkId> evicted;  // for a load: drop these first, in this order
  };

  // `page_bytes` only converts a budget of `pages` pages to bytes. `policy` is an online one of
  // capacity `pages`. Requires: 0 < pages < 2^32.
  TextureCache(uint64_t pages, uint64_t page_bytes, std::unique_ptr<Policy> policy);

  // Asks for a chunk that takes `pages` pages; a load hands `bytes` to the device. The spans live
  // until the next non-const call. A chunk id always means the same voxels: a changed chunk has
  // another id, or is erased first. Requires: pages > 0.
  Answer request(ChunkId chunk, uint32_t pages, uint64_t bytes);

  // Keeps a resident chunk until unpinAll(): one that the cluster being drawn needs. False when not
  // resident.
  bool pin(ChunkId chunk);
  void unpinAll();
  // Takes out a chunk that became invalid; counted as an eviction. False when it was not resident.
  bool erase(ChunkId chunk);

  // Forgets chunks that are not resident and that `is_used` denies: whether they were resident
  // before, and what a policy notes of them.
  template <class IsUsed>
  void forgetUnused(IsUsed&& is_used) {
    std::erase_if(keys_, [&](const auto& known) {
      const auto& [chunk, key] = known;
      const bool forgets = pages_of_[key].empty() && !is_used(chunk);
      if (forgets) forget(key);
      return forgets;
    });
  }
  // Chunks that something is remembered of.
  size_t known() const { return keys_.size(); }

  bool contains(ChunkId chunk) const { return !pagesOf(chunk).empty(); }
  // Empty when not resident.
  std::span<const uint32_t> pagesOf(ChunkId chunk) const;
  // The resident chunks, in no particular order.
  std::vector<ChunkId> residents() const;
  // For each page the chunk in it; kNoChunk if free. For pictures.
  std::vector<ChunkId> pageMap() const;
  static constexpr ChunkId kNoChunk = UINT64_MAX;

  uint64_t capacityPages() const { return policy_->capacity(); }
  uint64_t usedPages() const { return policy_->used(); }
  // current_bytes and the peak count the whole pages of residents, and stay within budget_bytes;
  // uploaded_bytes counts the bytes of loads as passed to request().
  const CacheCounters& counters() const { return counters_; }
  uint64_t pagesLoaded() const { return pages_loaded_; }  // since the last reset
  void resetCounters();

 private:
  Key keyOf(ChunkId chunk);  // a new one if it has none
  void forget(Key key);
  void release(Key key);
  uint32_t takeLowestPage();

  const uint64_t page_bytes_;
  std::unique_ptr<Policy> policy_;
  std::unordered_map<ChunkId, Key> keys_;
  std::vector<ChunkId> chunk_of_;                // by key
  std::vector<std::vector<uint32_t>> pages_of_;  // by key; empty when not resident
  std::vector<bool> was_resident_;               // by key
  std::vector<Key> free_keys_;                   // keys of forgotten chunks
  std::vector<uint64_t> free_pages_;             // a bit a page
  size_t lowest_word_ = 0;                       // no free page in the words before it
  CacheCounters counters_;
  uint64_t pages_loaded_ = 0;
  std::vector<Key> evicted_keys_;  // for the last request
  std::vector<ChunkId> evicted_;
};

}  // namespace sluice
