#include "src/render/read_ahead.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace sluice {
namespace {

// More would read blocks that a changed view or threshold makes useless.
constexpr size_t kMostStepsAhead = 8;

}  // namespace

ReadAhead::ReadAhead(TextureBuffer& buffer, const TexturePlan& plan,
                     std::span<const uint64_t> names, const TextureCache& cache,
                     std::span<const int64_t> order, Needs needs)
    : buffer_(buffer),
      plan_(plan),
      names_(names),
      cache_(cache),
      needs_(std::move(needs)),
      most_bytes_(buffer.counters().budget_bytes / 4) {
  std::unordered_set<int64_t> seen;  // chunks between two clusters are loaded for the first
  for (const int64_t cluster : order) {
    Step step{.cluster = cluster, .chunks = {}, .completes_cluster = false};
    uint64_t bytes = 0;
    for (const int64_t chunk : plan.clusters[static_cast<size_t>(cluster)].chunks) {
      if (!cache.contains(names[static_cast<size_t>(chunk)]) && seen.insert(chunk).second) {
        const uint64_t more = TextureBuffer::bytesOf(plan, plan.chunks[static_cast<size_t>(chunk)]);
        if (bytes > 0 && bytes + more > most_bytes_) {
          steps_.push_back(
              std::exchange(step, {.cluster = cluster, .chunks = {}, .completes_cluster = false}));
          bytes = 0;
        }
        bytes += more;
      }
      step.chunks.push_back(chunk);
    }
    step.completes_cluster = true;
    steps_.push_back(std::move(step));
  }
}

ReadAhead::~ReadAhead() {
  for (const Begun& begun : begun_) buffer_.cancel(begun.batch);
  for (const TextureBuffer::BatchPtr& batch : late_) buffer_.cancel(batch);
}

std::vector<int64_t> ReadAhead::absent(const Step& step, bool ahead) const {
  std::vector<int64_t> chunks;
  uint64_t bytes = 0;
  for (const int64_t chunk : step.chunks) {
    if (cache_.contains(names_[static_cast<size_t>(chunk)])) continue;
    if ((needs_.now && !needs_.now(chunk)) || (ahead && needs_.soon && !needs_.soon(chunk)))
      continue;
    bytes += bytesOf(chunk);
    // More than planned have gone from the cache: takeOne() has them one by one.
    if (!chunks.empty() && bytes > most_bytes_) break;
    chunks.push_back(chunk);
  }
  return chunks;
}

uint64_t ReadAhead::bytesOf(int64_t chunk) const {
  return TextureBuffer::bytesOf(plan_, plan_.chunks[static_cast<size_t>(chunk)]);
}

std::vector<int64_t> ReadAhead::soonAfter(size_t step) const {
  std::vector<int64_t> chunks;
  for (size_t i = step + 1; i < steps_.size() && !steps_[i - 1].completes_cluster; ++i)
    for (const int64_t chunk : absent(steps_[i], true)) chunks.push_back(chunk);
  return chunks;
}

TextureBuffer::BatchPtr ReadAhead::beginNow(std::span<const int64_t> chunks,
                                            std::span<const int64_t> soon) {
  for (;;) {
    TextureBuffer::BatchPtr batch = buffer_.tryBegin(plan_, names_, chunks, soon);
    if (batch != nullptr) return batch;
    // What is wanted now goes before what is wanted later.
    if (begun_.empty()) return buffer_.begin(plan_, names_, chunks, soon);
    buffer_.cancel(begun_.back().batch);
    begun_.pop_back();
  }
}

void ReadAhead::beginNext(bool may_wait) {
  while (begun_.size() < std::min(steps_.size(), kMostStepsAhead)) {
    std::vector<int64_t> chunks = absent(steps_[begun_.size()], true);
    const std::vector<int64_t> soon = soonAfter(begun_.size());
    TextureBuffer::BatchPtr batch = begun_.empty() && may_wait
                                        ? beginNow(chunks, soon)
                                        : buffer_.tryBegin(plan_, names_, chunks, soon);
    if (batch == nullptr) return;
    begun_.push_back({std::move(chunks), std::move(batch)});
  }
}

std::vector<ChunkTexelsPtr> ReadAhead::texelsOf(const Begun& begun, const Deadline& deadline) {
  if (!deadline) return buffer_.finish(begun.batch);
  std::vector<ChunkTexelsPtr> texels = buffer_.waitUntil(begun.batch, *deadline);
  if (std::find(texels.begin(), texels.end(), nullptr) == texels.end())
    return buffer_.finish(begun.batch);
  late_.push_back(begun.batch);
  return texels;
}

std::optional<ReadAhead::Taken> ReadAhead::take(const Deadline& deadline) {
  if (steps_.empty()) return std::nullopt;
  beginNext(!deadline);
  Taken taken{std::move(steps_.front()), {}};
  steps_.pop_front();
  if (needs_.now)
    std::erase_if(taken.step.chunks, [this](int64_t chunk) { return !needs_.now(chunk); });
  taken.texels.resize(taken.step.chunks.size());
  if (begun_.empty()) return taken;  // no room before the deadline
  const Begun begun = std::move(begun_.front());
  begun_.pop_front();
  putTexels(begun, deadline, taken);
  // Needed against expectation.
  Begun rest;
  for (const int64_t chunk : absent(taken.step, false))
    if (std::find(begun.chunks.begin(), begun.chunks.end(), chunk) == begun.chunks.end())
      rest.chunks.push_back(chunk);
  if (rest.chunks.empty()) return taken;
  rest.batch =
      deadline ? buffer_.tryBegin(plan_, names_, rest.chunks, {}) : beginNow(rest.chunks, {});
  if (rest.batch != nullptr) putTexels(rest, deadline, taken);
  return taken;
}

void ReadAhead::putTexels(const Begun& begun, const Deadline& deadline, Taken& taken) {
  const std::vector<ChunkTexelsPtr> texels = texelsOf(begun, deadline);
  const std::vector<int64_t>& chunks = taken.step.chunks;
  for (size_t i = 0; i < begun.chunks.size(); ++i) {
    const auto found = std::find(chunks.begin(), chunks.end(), begun.chunks[i]);
    if (found != chunks.end())
      taken.texels[static_cast<size_t>(found - chunks.begin())] = texels[i];
  }
}

ChunkTexelsPtr ReadAhead::takeOne(int64_t chunk) {
  const TextureBuffer::BatchPtr batch = beginNow(std::span(&chunk, 1), {});
  return buffer_.finish(batch).front();
}

}  // namespace sluice
