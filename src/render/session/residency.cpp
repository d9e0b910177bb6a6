#include "src/render/session/residency.h"

#include <algorithm>
#include <unordered_set>

#include "src/base/error.h"
#include "src/base/threads/clock.h"

namespace sluice {
namespace {

// Names that no plan in use has: of thresholds seen before, whose chunks level 3 may still hold.
constexpr size_t kMostUnusedNames = size_t{1} << 16;

std::vector<VolumeBuffer::Level> bufferLevels(const TimeStep& step) {
  const PyramidLayout layout = step.layout();
  std::vector<VolumeBuffer::Level> levels{{step.source, layout.finest()}};
  for (const CoarserStep& coarser : step.coarser)
    levels.push_back(
        {coarser.source, layout.level(static_cast<int>(levels.size())).blocks, coarser.spreads});
  return levels;
}

}  // namespace

Residency::Residency(const TimeStep& step, Device& device, const ResidencyOptions& options,
                     int threads, int64_t first_name)
    : device_(device),
      budgets_(shareMemory(options.memory_bytes, options.page, device.limits().texels,
                           needsOf(step, options.partition, options.beside_bytes),
                           readsAtOnce(*step.source, threads))),
      blocks_(bufferLevels(step), budgets_.volume_buffer, VolumeBuffer::Cold::kPacked),
      // A pool counts the calling thread, which only waits or helps: the readers are in addition to
      // it.
      readers_(budgets_.readers + 1),
      chunks_(blocks_, readers_, budgets_.texture_buffer),
      cache_(static_cast<uint64_t>(options.page.pages),
             static_cast<uint64_t>(options.page.pageBytes()),
             makePolicy(options.policy, static_cast<uint64_t>(options.page.pages), options.seed)),
      names_(first_name),
      first_id_(device.takeIdRange()) {
  SLUICE_CHECK_EQ(options.page.bytes_per_voxel,
                  static_cast<int64_t>(bytesPerVoxel(blocks_.type())));
  step.source->holdAtMost(budgets_.source);  // for all levels
}

Residency::~Residency() {
  for (const ChunkId id : cache_.residents()) device_.evict(first_id_ + id);
}

Residency::Made Residency::makeResident(const FramePlan& plan, ChunkPosition position,
                                        const ChunkTexelsPtr& texels) {
  const Chunk& chunk = plan.textures.chunks[position];
  const ChunkId id = modelId(plan.names[position]);
  const TextureCache::Answer answer = cache_.request(id, static_cast<uint32_t>(chunk.pages),
                                                     TextureBuffer::bytesOf(plan.textures, chunk));
  if (answer.outcome == Outcome::kDoesNotFit)
    failMemory("a cluster needs more than the texture cache's {} pages; give more --pages",
               cache_.capacityPages());
  // Pinned before it is loaded, so that the rest of its cluster cannot evict it.
  cache_.pin(id);
  if (answer.outcome != Outcome::kLoaded) return {};
  Stopwatch watch;
  try {
    // Evicted first: a device never holds more pages than the cache has.
    evict(answer.evicted);
    SLUICE_CHECK(texels != nullptr);
    // The stopwatch starts after the evictions, which are no upload.
    watch = Stopwatch();
    device_.makeResident(first_id_ + id, texels);
  } catch (...) {
    // The model must not list a chunk that the device did not get.
    cache_.erase(id);
    throw;
  }
  const bool is_copied = device_.limits().texels != TexelPlace::kBorrowed;
  return {static_cast<uint64_t>(chunk.pages), is_copied ? texels->byte_count : 0, watch.seconds()};
}

void Residency::evict(std::span<const ChunkId> ids) {
  size_t gone = 0;
  try {
    for (; gone < ids.size(); ++gone) device_.evict(first_id_ + ids[gone]);
  } catch (...) {
    device_.cancelFrame();  // so that there is nothing to be drawn first
    for (; gone < ids.size(); ++gone) device_.evict(first_id_ + ids[gone]);
    throw;
  }
}

void Residency::forgetUnused(const FramePlan& plan) {
  // Twice the plan's names, so that plans of many chunks do not look through all names each time.
  if (names_.kept() <= kMostUnusedNames + 2 * plan.names.size()) return;
  std::unordered_set<ChunkId> used;
  for (const ChunkName name : plan.names) used.insert(modelId(name));
  for (const ChunkId id : cache_.residents()) used.insert(id);
  names_.forgetUnused([&used](ChunkName name) { return used.contains(modelId(name)); });
  cache_.forgetUnused([&used](ChunkId id) { return used.contains(id); });
}

}  // namespace sluice
