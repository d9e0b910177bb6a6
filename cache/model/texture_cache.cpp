#include "cache/model/texture_cache.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "src/base/error.h"

namespace sluice {

TextureCache::TextureCache(uint64_t pages, uint64_t page_bytes, std::unique_ptr<Policy> policy)
    : page_bytes_(page_bytes), policy_(std::move(policy)), free_pages_((pages + 63) / 64, 0) {
  SLUICE_CHECK_LT(pages, uint64_t{UINT32_MAX});
  SLUICE_CHECK_EQ(policy_->capacity(), pages);
  for (uint64_t page = 0; page < pages; ++page)
    free_pages_[page / 64] |= uint64_t{1} << (page % 64);
  counters_.budget_bytes = pages * page_bytes;
}

TextureCache::Answer TextureCache::request(ChunkId chunk, uint32_t pages, uint64_t bytes) {
  const Key key = keyOf(chunk);
  // The last answer's spans point into these, and end with this call.
  evicted_keys_.clear();
  evicted_.clear();
  Answer answer;
  answer.outcome = policy_->request(key, pages, evicted_keys_);
  if (answer.outcome == Outcome::kHit) {
    // An id always means the same voxels, and so as many pages.
    SLUICE_CHECK_EQ(pages_of_[key].size(), size_t{pages});
    counters_.countHit();
    answer.pages = pages_of_[key];
    return answer;
  }
  counters_.countMiss();
  if (answer.outcome == Outcome::kDoesNotFit) {
    counters_.countFailure();
    return answer;
  }
  // Pages are given back before new ones are taken, so that the lowest free ones are known.
  for (const Key gone : evicted_keys_) {
    release(gone);
    evicted_.push_back(chunk_of_[gone]);
  }
  for (uint32_t i = 0; i < pages; ++i) pages_of_[key].push_back(takeLowestPage());
  answer.was_resident_before = was_resident_[key];
  was_resident_[key] = true;
  counters_.countLoad(pages * page_bytes_, answer.was_resident_before);
  counters_.uploaded_bytes += bytes;
  pages_loaded_ += pages;
  answer.pages = pages_of_[key];
  answer.evicted = evicted_;
  return answer;
}

bool TextureCache::pin(ChunkId chunk) {
  // A chunk that was never requested gets no key here.
  const auto known = keys_.find(chunk);
  return known != keys_.end() && policy_->pin(known->second);
}

void TextureCache::unpinAll() {
  policy_->unpinAll();
}

bool TextureCache::erase(ChunkId chunk) {
  const auto known = keys_.find(chunk);
  if (known == keys_.end() || !policy_->erase(known->second)) return false;
  release(known->second);
  return true;
}

std::span<const uint32_t> TextureCache::pagesOf(ChunkId chunk) const {
  const auto known = keys_.find(chunk);
  if (known == keys_.end()) return {};
  return pages_of_[known->second];
}

std::vector<ChunkId> TextureCache::residents() const {
  std::vector<ChunkId> chunks;
  for (Key key = 0; key < pages_of_.size(); ++key)
    if (!pages_of_[key].empty()) chunks.push_back(chunk_of_[key]);
  return chunks;
}

std::vector<ChunkId> TextureCache::pageMap() const {
  std::vector<ChunkId> map(policy_->capacity(), kNoChunk);
  for (Key key = 0; key < pages_of_.size(); ++key) {
    for (const uint32_t page : pages_of_[key]) map[page] = chunk_of_[key];
  }
  return map;
}

void TextureCache::resetCounters() {
  counters_.reset();
  pages_loaded_ = 0;
}

Key TextureCache::keyOf(ChunkId chunk) {
  if (const auto known = keys_.find(chunk); known != keys_.end()) return known->second;
  // Keys of chunks that were forgotten are used again, so that arrays by key stay as small as the
  // chunks in use.
  Key key = static_cast<Key>(chunk_of_.size());
  if (free_keys_.empty()) {
    chunk_of_.push_back(chunk);
    pages_of_.emplace_back();
    was_resident_.push_back(false);
  } else {
    key = free_keys_.back();
    free_keys_.pop_back();
    chunk_of_[key] = chunk;
  }
  keys_.emplace(chunk, key);
  return key;
}

void TextureCache::forget(Key key) {
  policy_->erase(key);  // from the ghost lists
  was_resident_[key] = false;
  free_keys_.push_back(key);
}

void TextureCache::release(Key key) {
  for (const uint32_t page : pages_of_[key]) {
    free_pages_[page / 64] |= uint64_t{1} << (page % 64);
    lowest_word_ = std::min<size_t>(lowest_word_, page / 64);
  }
  counters_.countEviction(pages_of_[key].size() * page_bytes_);
  pages_of_[key].clear();
}

uint32_t TextureCache::takeLowestPage() {
  // The policy has made room, so that some page is free.
  while (free_pages_[lowest_word_] == 0) ++lowest_word_;
  uint64_t& word = free_pages_[lowest_word_];
  const int bit = std::countr_zero(word);
  word &= word - 1;
  return static_cast<uint32_t>(lowest_word_ * 64 + static_cast<size_t>(bit));
}

}  // namespace sluice
