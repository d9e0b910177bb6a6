#include "tools/plan/planned_channel.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <utility>

#include "src/base/values/bytes.h"
#include "tools/command_line/console.h"
#include "tools/options/shared_options.h"
#include "tools/outputs/cut_report.h"
#include "tools/outputs/report.h"
#include "tools/plan/plan_forecast.h"

namespace sluice {
namespace {

// The part of a report that channels have as well as their sum.
nlohmann::json sumJson(const PlannedSum& sum, Algorithm algorithm) {
  const AlgorithmCost& chosen = sum.costs[static_cast<size_t>(algorithm)];
  nlohmann::json report{
      {"blocks", {{"white", sum.white}, {"grey", sum.grey}, {"black", sum.black}}},
      {"clusters", chosen.clusters},
      {"read", readJson(sum.forecast)},
      {"most_read", mostReadJson(sum.forecast)},
      {"memory", memoryJson(sum.forecast)},
      {"classify_seconds", sum.classify_seconds},
      {"plan_seconds", chosen.seconds},
      {"seconds", sum.classify_seconds + chosen.seconds}};
  for (size_t i = 0; i < sum.costs.size(); ++i)
    report["algorithms"][std::string(name(kAlgorithms[i]))] = {{"chunks", sum.costs[i].chunks},
                                                               {"pages", sum.costs[i].pages},
                                                               {"bytes", sum.costs[i].bytes},
                                                               {"binds", sum.costs[i].binds}};
  return report;
}

nlohmann::json channelJson(const PlannedChannel& channel, const PlannedSum& sum,
                           Algorithm algorithm) {
  nlohmann::json report = sumJson(sum, algorithm);
  report["transfer"] = channel.transfer.name;
  if (channel.boxes) report["partition"] = boxesJson(*channel.boxes);
  if (channel.shown.blocks->cut) report["cut"] = cutJson(*channel.shown.blocks->cut);
  return report;
}

void print(const AlgorithmCosts& costs, Algorithm algorithm, double classify_seconds,
           const PageGeometry& page) {
  say("{:<13} {:>8} {:>9} {:>12} {:>7}   pages of {}, {} in the cache\n", "algorithm", "chunks",
      "pages", "bytes", "binds", printPageSize(page.size_vox), page.pages);
  for (size_t i = 0; i < costs.size(); ++i)
    say("{:<13} {:>8} {:>9} {:>12} {:>7}\n", name(kAlgorithms[i]), costs[i].chunks, costs[i].pages,
        formatBytes(costs[i].bytes), costs[i].binds);
  const AlgorithmCost& chosen = costs[static_cast<size_t>(algorithm)];
  say("{} cluster{} of {} x {} blocks; classified in {:.2f} ms, planned in {:.2f} ms\n",
      chosen.clusters, chosen.clusters == 1 ? "" : "s", chosen.cluster_blocks.x,
      chosen.cluster_blocks.y, 1e3 * classify_seconds, 1e3 * chosen.seconds);
}

}  // namespace

PlannedSum sumOf(const std::vector<PlannedChannel>& channels) {
  PlannedSum sum;
  uint64_t least_bytes = 0;  // of one channel; all get the same share
  for (const PlannedChannel& channel : channels) {
    least_bytes = std::max(least_bytes, channel.forecast.least_bytes);
    sum.white += channel.shown.blocks->white;
    sum.grey += channel.shown.blocks->grey;
    sum.black += channel.shown.blocks->black;
    sum.classify_seconds += channel.shown.seconds;
    if (&channel == &channels.front()) {
      sum.costs = channel.costs;
      sum.forecast = channel.forecast;
      continue;
    }
    add(sum.forecast, channel.forecast);
    for (size_t i = 0; i < sum.costs.size(); ++i) {
      AlgorithmCost& cost = sum.costs[i];
      const AlgorithmCost& more = channel.costs[i];
      cost.shared_blocks += more.shared_blocks;
      cost.shared_voxel_bytes += more.shared_voxel_bytes;
      cost.chunks += more.chunks;
      cost.clusters += more.clusters;
      cost.pages += more.pages;
      cost.binds += more.binds;
      cost.bytes += more.bytes;
      cost.seconds += more.seconds;
    }
  }
  sum.forecast.least_bytes = least_bytes * channels.size();
  return sum;
}

nlohmann::json reportOf(const std::vector<PlannedChannel>& channels, Algorithm algorithm) {
  const PlannedChannel& first = channels.front();
  nlohmann::json report = channelJson(first, sumOf(channels), algorithm);
  report["volume"] = volumeJson(first.volume);
  if (channels.size() == 1) return report;
  for (const PlannedChannel& channel : channels) {
    PlannedSum own{.white = channel.shown.blocks->white,
                   .grey = channel.shown.blocks->grey,
                   .black = channel.shown.blocks->black,
                   .costs = channel.costs,
                   .forecast = channel.forecast,
                   .classify_seconds = channel.shown.seconds};
    nlohmann::json of_channel = channelJson(channel, own, algorithm);
    of_channel["channel"] = idJson(channel.volume.channel);
    of_channel["name"] = channel.volume.channel.name;
    report["channels"].push_back(std::move(of_channel));
  }
  return report;
}

void print(const PlannedChannel& channel, Algorithm algorithm) {
  print(channel.costs, algorithm, channel.shown.seconds, channel.volume.page);
  if (isCoarser(*channel.shown.blocks)) say("{}\n", cutLine(*channel.shown.blocks->cut));
}

void printIndex(const PlannedChannel& channel) {
  const IndexedVolume& volume = channel.volume;
  if (volume.stand_in) say("{}\n", volume.standInNote());
  if (!volume.stand_in && volume.index->state != "read")
    say("index {}: this plan has read the whole volume for it, {}\n", volume.index->state,
        volume.index->path.empty() ? "and so will the next one" : "the next one reads no voxel");
  if (channel.boxes) print(*channel.boxes);
}

}  // namespace sluice
