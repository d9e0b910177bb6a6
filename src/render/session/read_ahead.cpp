#include "src/render/session/read_ahead.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

namespace sluice {
namespace {

// More would read blocks that a changed view or threshold makes useless.
constexpr size_t kMostStepsAhead = 8;

}  // namespace

ReadAhead::ReadAhead(Residency& residency, FramePlanPtr plan, const DrawOrder& order,
                     ReadPurpose purpose, Needs needs)
    : residency_(residency),
      buffer_(residency.chunks()),
      plan_(std::move(plan)),
      purpose_(std::move(purpose)),
      needs_(std::move(needs)),
      // In addition to the bytes that a device borrows.
      most_bytes_((residency.budgets().texture_buffer - residency.budgets().borrowed) / 4) {
  std::unordered_set<ChunkPosition> seen;  // chunks between two clusters are loaded for the first
  for (const Visit& visit : order.visits) {
    const Cluster& cluster = plan_->textures.clusters[visit.cluster];
    Step step{.cluster = visit.cluster, .chunks = {}, .completes_cluster = false};
    uint64_t bytes = 0;
    for (const ChunkPosition chunk : cluster.chunks) {
      if (!isHeld(chunk) && seen.insert(chunk).second) {
        const uint64_t more = bytesOf(chunk);
        // A step has at least one chunk, so that a chunk larger than the limit is read, too.
        if (bytes > 0 && bytes + more > most_bytes_) {
          steps_.push_back(std::exchange(
              step, {.cluster = visit.cluster, .chunks = {}, .completes_cluster = false}));
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

bool ReadAhead::isHeld(ChunkPosition chunk) const {
  return residency_.isResident(plan_->names[chunk]);
}

uint64_t ReadAhead::bytesOf(ChunkPosition chunk) const {
  const TexturePlan& textures = plan_->textures;
  return TextureBuffer::bytesOf(textures, textures.chunks[chunk]);
}

std::vector<ChunkPosition> ReadAhead::absent(const Step& step, bool ahead) const {
  // Looked up when the step is begun and when it is taken: the cache may have evicted chunks since.
  std::vector<ChunkPosition> chunks;
  uint64_t bytes = 0;
  for (const ChunkPosition chunk : step.chunks) {
    if (isHeld(chunk)) continue;
    if ((needs_.now && !needs_.now(chunk)) || (ahead && needs_.soon && !needs_.soon(chunk)))
      continue;
    bytes += bytesOf(chunk);
    // More chunks than planned have gone from the cache: takeOne() reads them one by one.
    if (!chunks.empty() && bytes > most_bytes_) break;
    chunks.push_back(chunk);
  }
  return chunks;
}

std::vector<ChunkPosition> ReadAhead::soonAfter(size_t step) const {
  std::vector<ChunkPosition> chunks;
  // Steps of one cluster only: its blocks lie in the same rows of the file.
  for (size_t i = step + 1; i < steps_.size() && !steps_[i - 1].completes_cluster; ++i)
    for (const ChunkPosition chunk : absent(steps_[i], true)) chunks.push_back(chunk);
  return chunks;
}

std::optional<ReadAhead::Begun> ReadAhead::tryBegin(std::vector<ChunkPosition> chunks,
                                                    std::span<const ChunkPosition> soon) {
  TextureBuffer::BatchPtr batch =
      buffer_.tryBegin(plan_->textures, plan_->names, chunks, soon, purpose_);
  if (batch == nullptr) return std::nullopt;
  return Begun(buffer_, std::move(chunks), std::move(batch));
}

ReadAhead::Begun ReadAhead::beginNow(std::vector<ChunkPosition> chunks,
                                     std::span<const ChunkPosition> soon) {
  for (;;) {
    if (std::optional<Begun> begun = tryBegin(chunks, soon)) return std::move(*begun);
    // The chunks wanted now have priority over chunks wanted later.
    if (begun_.empty()) break;
    begun_.pop_back();
  }
  TextureBuffer::BatchPtr batch =
      buffer_.begin(plan_->textures, plan_->names, chunks, soon, purpose_);
  return {buffer_, std::move(chunks), std::move(batch)};
}

void ReadAhead::beginNext(bool may_wait) {
  while (begun_.size() < std::min(steps_.size(), kMostStepsAhead)) {
    std::vector<ChunkPosition> chunks = absent(steps_[begun_.size()], true);
    const std::vector<ChunkPosition> soon = soonAfter(begun_.size());
    // Only the step that is drawn next may wait for room. The others take what is left.
    if (begun_.empty() && may_wait) {
      begun_.push_back(beginNow(std::move(chunks), soon));
      continue;
    }
    std::optional<Begun> begun = tryBegin(std::move(chunks), soon);
    if (!begun) return;
    begun_.push_back(std::move(*begun));
  }
}

std::optional<ReadAhead::Taken> ReadAhead::take(const Deadline& deadline) {
  if (steps_.empty()) return std::nullopt;
  beginNext(!deadline);
  Taken taken{std::move(steps_.front()), {}};
  steps_.pop_front();
  // Updates of the opacity map may have hidden chunks since the step was begun.
  if (needs_.now)
    std::erase_if(taken.step.chunks, [this](ChunkPosition chunk) { return !needs_.now(chunk); });
  taken.texels.resize(taken.step.chunks.size());
  if (begun_.empty()) return taken;  // no room before the deadline
  Begun begun = std::move(begun_.front());
  begun_.pop_front();
  // The chunk is needed against expectation.
  std::vector<ChunkPosition> rest;
  for (const ChunkPosition chunk : absent(taken.step, false))
    if (std::ranges::find(begun.chunks(), chunk) == begun.chunks().end()) rest.push_back(chunk);
  putTexels(std::move(begun), deadline, taken);
  if (rest.empty()) return taken;
  if (!deadline)
    putTexels(beginNow(std::move(rest), {}), deadline, taken);
  else if (std::optional<Begun> more = tryBegin(std::move(rest), {}))
    putTexels(std::move(*more), deadline, taken);
  return taken;
}

void ReadAhead::putTexels(Begun begun, const Deadline& deadline, Taken& taken) {
  std::vector<ChunkTexelsPtr> texels =
      deadline ? begun.waitUntil(*deadline) : std::vector<ChunkTexelsPtr>();
  // finish() would wait for the chunks that are late.
  const bool is_late = std::ranges::find(texels, nullptr) != texels.end();
  if (!is_late) texels = begun.finish();
  const std::vector<ChunkPosition>& chunks = taken.step.chunks;
  // The batch may hold chunks that are no longer needed.
  for (size_t i = 0; i < begun.chunks().size(); ++i) {
    const auto found = std::ranges::find(chunks, begun.chunks()[i]);
    if (found != chunks.end())
      taken.texels[static_cast<size_t>(found - chunks.begin())] = texels[i];
  }
  // It goes on filling: the chunks may serve the next frame.
  if (is_late) late_.push_back(std::move(begun));
}

ChunkTexelsPtr ReadAhead::takeOne(ChunkPosition chunk) {
  return beginNow({chunk}, {}).finish().front();
}

}  // namespace sluice
