#include "src/library/drawing/cost/planned_channels.h"

#include <algorithm>
#include <utility>

namespace sluice {
namespace {

PlannedPart partOf(const ChannelShare& share) {
  return {*share.look.volume, share.step, *share.look.transfer, share.frame, share.page};
}

void requireRoomToPlan(const std::vector<ChannelShare>& shares, TexelPlace texels) {
  try {
    for (const ChannelShare& share : shares)
      requireRoomToPlan(*share.look.volume, share.page, share.others_bytes, share.frame,
                        share.machine, texels);
  } catch (const Error& error) {
    failOfShare(error, shares.size());
  }
}

// The least memory is left to the caller: a sum would be too little for channels that differ.
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
  // Before planning: a plan that does not fit would take the memory that it says is missing.
  requireRoomToPlan(shares, texels);
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
  return channels;
}

PlannedSum costOf(const PlannedChannel& channel) {
  const VisibleBlocks& blocks = *channel.shown.blocks;
  return {blocks.white,  blocks.grey,      blocks.black,
          channel.costs, channel.forecast, channel.shown.seconds};
}

PlannedSum sumOf(std::span<const PlannedChannel> channels) {
  PlannedSum sum = costOf(channels.front());
  uint64_t least_bytes = sum.forecast.least_bytes;  // of one channel; all get the same share
  for (const PlannedChannel& channel : channels.subspan(1)) {
    least_bytes = std::max(least_bytes, channel.forecast.least_bytes);
    add(sum, costOf(channel));
  }
  sum.forecast.least_bytes = least_bytes * channels.size();
  return sum;
}

}  // namespace sluice
