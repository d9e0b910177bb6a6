#include "src/library/drawing/cost/planned_channels.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include "src/library/drawing/cost/picture_memory.h"
#include "src/render/light/coarse_extinction.h"
#include "src/render/session/budgets.h"

namespace sluice {
namespace {

using NeedOfMemory = std::function<uint64_t(uint64_t memory_bytes)>;

PlannedPart partOf(const ChannelShare& share) {
  return {*share.look.volume, share.step, *share.look.transfer, share.frame, share.page};
}

// The bytes that a channel holds beside the levels if all channels have `memory_bytes` together, in
// place of `now_bytes`: the plan of a cut may take a part of the memory.
uint64_t othersAt(const ChannelShare& share, size_t channels, uint64_t memory_bytes,
                  uint64_t now_bytes, WorkerPool& pool) {
  const IndexedVolume& volume = *share.look.volume;
  if (!share.frame.cut || volume.pyramid == nullptr) return share.others_bytes;
  FrameOptions then = share.frame;
  for (const PictureRow row : {PictureRow::kOne, PictureRow::kMore}) {
    const uint64_t now = cutBytes(now_bytes, row) / channels;
    const uint64_t held = share.frame.cut->most_held_bytes;
    // Each channel's share of the memory is rounded down.
    if (std::max(now, held) - std::min(now, held) > channels) continue;
    then.cut->most_held_bytes = cutBytes(memory_bytes, row) / channels;
    break;
  }
  if (then.cut == share.frame.cut) return share.others_bytes;
  const TransferFunction& transfer = *share.look.transfer;
  return share.others_bytes - planBytes(volume, transfer, share.frame, pool) +
         planBytes(volume, transfer, then, pool);
}

// The bytes that the channels need together of so much memory for all of them, as their sessions
// do; see leastMemoryBytes().
uint64_t needOfMemory(const std::vector<ChannelShare>& shares, Combine combine, TexelPlace texels,
                      uint64_t memory_bytes, WorkerPool& pool) {
  const uint64_t now_bytes = shares.size() * memoryBudget(shares.front().machine);
  std::vector<uint64_t> beside_bytes;
  std::vector<PageGeometry> pages;
  for (const ChannelShare& share : shares) {
    MachineOptions machine = share.machine;
    // 0 would mean half of the free memory (memoryBudget()).
    machine.memory_bytes = std::max<uint64_t>(1, memory_bytes / shares.size());
    const BesideShare beside = besideShare(
        *share.look.volume, machine, share.frame.partition, pictureDemand(machine, share.frame),
        othersAt(share, shares.size(), memory_bytes, now_bytes, pool));
    beside_bytes.push_back(beside.beside_bytes);
    pages.push_back(share.page);
    pages.back().pages = beside.pages;
  }
  if (blends(combine, shares.size())) {
    std::vector<std::pair<const IndexedVolume*, PageGeometry*>> even;
    for (size_t i = 0; i < shares.size(); ++i) even.emplace_back(shares[i].look.volume, &pages[i]);
    evenOutPages(even);
  }
  uint64_t most = 0;
  for (size_t i = 0; i < shares.size(); ++i) {
    const IndexedVolume& volume = *shares[i].look.volume;
    const BufferNeeds needs = needsOf(volume.step(), shares[i].frame.partition, beside_bytes[i]);
    most = std::max(most, textureMemoryBytes(pages[i], texels) + leastBufferBytes(pages[i], needs));
  }
  return shares.size() * most;
}

void requireRoomToPlan(const std::vector<ChannelShare>& shares, TexelPlace texels,
                       const NeedOfMemory& need_of) {
  try {
    for (const ChannelShare& share : shares)
      requireRoomToPlan(*share.look.volume, share.page, share.others_bytes, share.frame,
                        share.machine, texels);
  } catch (const Error& error) {
    const uint64_t refused = shares.size() * memoryBudget(shares.front().machine);
    std::optional<uint64_t> least;
    if (need_of(refused) > refused) least = leastMemoryBytes(need_of, refused);
    failOfShare(error, shares.size(), least);
  }
}

// The least memory is left to the caller, since it is that of all channels together.
void add(Forecast& sum, const Forecast& more) {
  sum.blocks += more.blocks;
  sum.voxel_bytes += more.voxel_bytes;
  sum.most_blocks += more.most_blocks;
  sum.most_voxel_bytes += more.most_voxel_bytes;
  if (more.stored) sum.stored = sum.stored.value_or(StoredReads()) += *more.stored;
  sum.budget_bytes += more.budget_bytes;
  sum.fits_budget = sum.fits_budget && more.fits_budget;
  sum.buffer_bytes += more.buffer_bytes;
  sum.index_bytes += more.index_bytes;
  sum.picture_bytes += more.picture_bytes;
}

void add(AlgorithmCost& sum, const AlgorithmCost& more) {
  sum.wanted.blocks += more.wanted.blocks;
  sum.wanted.voxel_bytes += more.wanted.voxel_bytes;
  sum.chunks += more.chunks;
  sum.clusters += more.clusters;
  sum.pages += more.pages;
  sum.binds += more.binds;
  sum.bytes += more.bytes;
  sum.seconds += more.seconds;
}

void add(PlannedSum& sum, const PlannedSum& more) {
  sum.white += more.white;
  sum.grey += more.grey;
  sum.black += more.black;
  sum.classify_seconds += more.classify_seconds;
  for (size_t i = 0; i < sum.costs.size(); ++i) add(sum.costs[i], more.costs[i]);
  add(sum.forecast, more.forecast);
}

}  // namespace

std::vector<PlannedChannel> plannedChannels(const std::vector<ChannelShare>& shares,
                                            Combine combine, BlockChooser* chooser,
                                            TexelPlace texels, WorkerPool& pool) {
  for (const ChannelShare& share : shares)
    if (share.frame.lighting.looksAround())
      requireFollowedByLight(*share.look.transfer, share.look.volume->source->layout());
  // Before planning: a plan that does not fit would take the memory that it says is missing.
  const NeedOfMemory need_of = [&](uint64_t memory_bytes) {
    return needOfMemory(shares, combine, texels, memory_bytes, pool);
  };
  requireRoomToPlan(shares, texels, need_of);
  std::vector<PlannedBlocks> shown;
  // Blended channels must agree on their blocks; added ones are chosen one by one.
  if (blends(combine, shares.size())) {
    std::vector<PlannedPart> parts;
    parts.reserve(shares.size());
    for (const ChannelShare& share : shares) parts.push_back(partOf(share));
    shown = plannedTogether(parts, pool);
  } else {
    shown.reserve(shares.size());
    for (const ChannelShare& share : shares)
      shown.push_back(plannedBlocks(partOf(share), chooser, pool));
  }
  std::vector<PlannedChannel> channels;
  channels.reserve(shares.size());
  for (size_t i = 0; i < shares.size(); ++i) {
    const ChannelShare& share = shares[i];
    const IndexedVolume& volume = *share.look.volume;
    shown[i].strips = plannedStrips(volume, share.machine, share.frame, share.others_bytes);
    const AlgorithmCosts costs = algorithmCosts(volume, shown[i], share.frame, share.page, pool);
    const AlgorithmCost& chosen = costs[static_cast<size_t>(share.frame.algorithm)];
    const Forecast forecast = forecastOf({volume, shown[i], share.page, chosen, share.others_bytes,
                                          share.frame, share.machine, texels});
    channels.push_back({share, std::move(shown[i]), costs, forecast});
  }
  // Less than a byte is too little for any picture, from which the search goes up.
  const uint64_t least_bytes = leastMemoryBytes(need_of, 1);
  const uint64_t each = (least_bytes + shares.size() - 1) / shares.size();
  for (PlannedChannel& channel : channels) {
    channel.forecast.least_bytes = each;
    channel.forecast.fits_budget = each <= channel.forecast.budget_bytes;
  }
  return channels;
}

PlannedSum costOf(const PlannedChannel& channel) {
  const VisibleBlocks& blocks = *channel.shown.blocks;
  return {blocks.white,  blocks.grey,      blocks.black,
          channel.costs, channel.forecast, channel.shown.seconds};
}

PlannedSum sumOf(std::span<const PlannedChannel> channels) {
  PlannedSum sum = costOf(channels.front());
  for (const PlannedChannel& channel : channels.subspan(1)) add(sum, costOf(channel));
  // All channels get the same share.
  sum.forecast.least_bytes *= channels.size();
  return sum;
}

}  // namespace sluice
