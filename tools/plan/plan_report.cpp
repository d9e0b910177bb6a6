#include "tools/plan/plan_report.h"

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

nlohmann::json channelJson(const PlanToReport& plan, size_t channel, const PlannedSum& sum) {
  const PlannedChannel& of = plan.channels[channel];
  nlohmann::json report = sumJson(sum, plan.algorithm);
  report["transfer"] = of.share.look.transfer->name;
  if (!plan.boxes.empty()) report["partition"] = boxesJson(plan.boxes[channel]);
  if (of.shown.blocks->cut) report["cut"] = cutJson(*of.shown.blocks->cut);
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

nlohmann::json reportOf(const PlanToReport& plan) {
  nlohmann::json report = channelJson(plan, 0, sumOf(plan.channels));
  report["volume"] = volumeJson(*plan.channels.front().share.look.volume);
  // Readers of a plan of one channel find its numbers at the top alone.
  if (plan.channels.size() == 1) return report;
  for (size_t i = 0; i < plan.channels.size(); ++i) {
    const ShownChannel& shown = plan.channels[i].share.look.volume->channel;
    nlohmann::json of_channel = channelJson(plan, i, costOf(plan.channels[i]));
    of_channel["channel"] = idJson(shown);
    of_channel["name"] = shown.name;
    report["channels"].push_back(std::move(of_channel));
  }
  return report;
}

void printTables(const PlanToReport& plan) {
  for (const PlannedChannel& channel : plan.channels) {
    const VisibleBlocks& blocks = *channel.shown.blocks;
    if (plan.channels.size() > 1) say("{}\n", channel.share.look.volume->channel.title());
    print(channel.costs, plan.algorithm, channel.shown.seconds, channel.share.page);
    if (isCoarser(blocks)) say("{}\n", cutLine(*blocks.cut));
  }
}

void printIndices(const PlanToReport& plan) {
  std::vector<const IndexedVolume*> volumes;
  for (const PlannedChannel& channel : plan.channels) volumes.push_back(channel.share.look.volume);
  for (const std::string& note : standInNotes(volumes)) say("{}\n", note);
  for (size_t i = 0; i < plan.channels.size(); ++i) {
    const IndexedVolume& volume = *plan.channels[i].share.look.volume;
    // A plan that took minutes owes the reason, and whether the next one takes them again.
    if (!volume.stand_in && volume.index->origin != IndexOrigin::kRead)
      say("index {}: this plan has read the whole volume for it, {}\n", name(volume.index->origin),
          volume.index->path.empty() ? "and so will the next one" : "the next one reads no voxel");
    if (!plan.boxes.empty()) print(plan.boxes[i]);
  }
}

}  // namespace sluice
