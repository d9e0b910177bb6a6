#include "src/texture/texture_buffer.h"

#include <algorithm>
#include <cstring>

#include "src/base/bytes.h"
#include "src/base/clock.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"
#include "src/texture/fill_chunk.h"

namespace sluice {

// A texture block on its way into a chunk.
struct TextureBuffer::Filling {
  const TextureBlock* block;
  ChunkTexels* into;
};

TextureBuffer::TextureBuffer(VolumeBuffer& blocks, WorkerPool& pool, uint64_t budget_bytes)
    : blocks_(blocks), pool_(pool) {
  counters_.budget_bytes = budget_bytes;
}

uint64_t TextureBuffer::bytesOf(const TexturePlan& plan, const Chunk& chunk) {
  return static_cast<uint64_t>(chunk.pages * plan.page.pageBytes());
}

void TextureBuffer::makeRoom(uint64_t bytes) {
  auto victim = recent_.end();
  while (counters_.current_bytes + bytes > counters_.budget_bytes) {
    do {
      if (victim == recent_.begin())
        fail(
            "the texture buffer of {} cannot hold {} more beside the {} in use; give more "
            "--memory, a smaller --block or fewer --pages",
            formatBytes(counters_.budget_bytes), formatBytes(bytes),
            formatBytes(counters_.current_bytes));
      --victim;
    } while (victim->texels.use_count() > 1);
    counters_.countEviction(victim->texels->byte_count);
    entries_.erase(victim->name);
    victim = recent_.erase(victim);
  }
}

std::vector<ChunkTexelsPtr> TextureBuffer::acquire(const TexturePlan& plan,
                                                   std::span<const uint64_t> names,
                                                   std::span<const int64_t> chunks) {
  std::vector<ChunkTexelsPtr> texels;
  std::vector<Filling> fillings;
  std::vector<std::pair<uint64_t, std::shared_ptr<ChunkTexels>>> fresh;
  std::unordered_map<uint64_t, size_t> fresh_at;  // name -> position in fresh
  uint64_t fresh_bytes = 0;
  for (const int64_t position : chunks) {
    const Chunk& chunk = plan.chunks[static_cast<size_t>(position)];
    const uint64_t name = names[static_cast<size_t>(position)];
    const auto found = entries_.find(name);
    if (found != entries_.end()) {
      counters_.countHit();
      recent_.splice(recent_.begin(), recent_, found->second);
      texels.push_back(found->second->texels);
      continue;
    }
    counters_.countMiss();
    const auto twin = fresh_at.find(name);
    if (twin != fresh_at.end()) {  // asked for twice: one load serves both
      counters_.countCoalesced();
      texels.push_back(fresh[twin->second].second);
      continue;
    }
    try {
      makeRoom(fresh_bytes + bytesOf(plan, chunk));
    } catch (const Error&) {
      for (size_t i = 0; i <= fresh.size(); ++i) counters_.countFailure();
      throw;
    }
    auto made = std::make_shared<ChunkTexels>();
    made->storage_vox = plan.page.pageGridOf(chunk.size_vox) * plan.page.size_vox;
    made->byte_count = bytesOf(plan, chunk);
    made->bytes = std::make_unique<std::byte[]>(made->byte_count);
    for (const int64_t block : chunk.blocks)
      fillings.push_back({&plan.blocks[static_cast<size_t>(block)], made.get()});
    fresh_bytes += made->byte_count;
    fresh_at.emplace(name, fresh.size());
    fresh.emplace_back(name, made);
    texels.push_back(made);
  }
  try {
    fill(plan, fillings);
  } catch (...) {
    for (size_t i = 0; i < fresh.size(); ++i) counters_.countFailure();
    throw;
  }
  for (auto& [name, made] : fresh) {
    counters_.countLoad(made->byte_count, !seen_.insert(name).second);
    recent_.push_front({name, std::move(made)});
    entries_[name] = recent_.begin();
  }
  return texels;
}

void TextureBuffer::fill(const TexturePlan& plan, const std::vector<Filling>& fillings) {
  // In the order of the volume, so that neighbours along x are read together.
  std::vector<Filling> sorted = fillings;
  std::sort(sorted.begin(), sorted.end(),
            [](const Filling& a, const Filling& b) { return a.block->block < b.block->block; });
  // What all threads hold at once stays within half of level 2.
  const uint64_t share =
      blocks_.counters().budget_bytes / 2 / static_cast<uint64_t>(pool_.threads());
  const size_t most = std::max<size_t>(1, share / blocks_.blockBytes());
  std::vector<std::pair<size_t, size_t>> runs;
  for (size_t from = 0; from < sorted.size();) {
    size_t to = from + 1;
    while (to < sorted.size() && to - from < most &&
           sorted[to].block->block == sorted[to - 1].block->block + 1 &&
           sorted[to].block->block % plan.layout.grid.x != 0)
      ++to;
    runs.emplace_back(from, to);
    from = to;
  }
  pool_.parallelFor(static_cast<int64_t>(runs.size()), [&](int64_t i) {
    throwIfInterrupted();
    const auto [from, to] = runs[static_cast<size_t>(i)];
    std::vector<BlockKey> keys;
    for (size_t at = from; at < to; ++at) keys.push_back({plan.time, sorted[at].block->block});
    const std::vector<VolumeBlockPtr> blocks = blocks_.acquire(keys);
    const Stopwatch watch;
    for (size_t at = from; at < to; ++at)
      copyTextureBlock(*sorted[at].block, *blocks[at - from], sorted[at].into->storage_vox,
                       sorted[at].into->span());
    copy_ns_ += static_cast<int64_t>(watch.seconds() * 1e9);
  });
  for (const Filling& filling : fillings)
    counters_.decoded_bytes += static_cast<uint64_t>(filling.block->voxels.count()) *
                               static_cast<uint64_t>(plan.page.bytes_per_voxel);
}

}  // namespace sluice
