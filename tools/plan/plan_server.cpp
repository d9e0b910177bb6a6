#include "tools/plan/plan_server.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/web/address.h"
#include "src/base/values/bytes.h"
#include "src/library/drawing/scene/resources.h"
#include "src/library/opening/channel_looks.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

nlohmann::json storeJson(const StoredReads& reads) {
  return {{"requests", reads.requests()},
          {"chunks", reads.chunks},
          {"indices", reads.indices},
          {"cached", reads.kept},
          {"most_bytes", reads.most_bytes}};
}

std::string requestsText(const StoredReads& reads) {
  std::string text = fmt::format("{} request{}, {} at most", reads.requests(),
                                 reads.requests() == 1 ? "" : "s", formatBytes(reads.most_bytes));
  if (reads.indices > 0) text += fmt::format(", {} of them for indices of shards", reads.indices);
  if (reads.kept > 0) text += fmt::format("; {} are in the cache and bring no bytes", reads.kept);
  return text;
}

}  // namespace

std::optional<PassForecast> passOverServer(const VolumeArguments& volume, const LookArguments& look,
                                           const ResourceArguments& resources,
                                           const FrameOptions& frame) {
  // Local files are read in the first pass anyway; only a server makes its bytes a question.
  if (!isAddress(volume.inputs.front())) return std::nullopt;
  std::optional<PassForecast> all;
  const std::vector<ChannelSource> channels = openChannels(volume);
  const VolumeLayout& first = channels.front().source->layout();
  for (const ChannelSource& channel : channels) {
    const IndexNeeds needs =
        pictureNeeds(lookOfChannel(look, channel.channel), frame, FinestLevel::kMayWait);
    const auto pass = passForecast(*channel.source, volume,
                                   withBlocksOfFirst(resources, channel.source->layout(), first),
                                   needs, indexWish(resources.index_dir));
    if (!pass) continue;
    if (!all) {
      all = pass;
      continue;
    }
    all->reads += pass->reads;
    // The channels are told as one pass, at the finest level that any of them reads.
    all->level = std::min(all->level, pass->level);
    all->is_all = all->is_all || pass->is_all;
  }
  return all;
}

void addFinestLevel(PassForecast& pass, const IndexedVolume& volume) {
  pass.reads += storedReadsOfLevel(*volume.source, volume.time, 0).value_or(StoredReads());
  pass.level = 0;
  pass.is_all = true;
}

std::string passLine(const VolumeArguments& volume, const PassForecast& pass) {
  const std::string name = withoutSecrets(volume.inputs.front());
  if (pass.is_all)
    return fmt::format("{}: has no index here, so that the first picture reads all of level {}: {}",
                       name, pass.level, requestsText(pass.reads));
  return fmt::format("{}: has no index here, so that level {} is read for its values: {}", name,
                     pass.level, requestsText(pass.reads));
}

void addStoreJson(nlohmann::json& report, const Forecast& forecast,
                  const std::optional<PassForecast>& pass) {
  // A volume that is no store of chunks has no chunks to count.
  if (!forecast.stored && !pass) return;
  StoredReads all = forecast.stored.value_or(StoredReads());
  nlohmann::json store = storeJson(all);
  store["most_decodes"] = all.decodes;
  store["decoded_bytes"] = all.decoded_bytes;
  if (pass) {
    store["first_pass"] = storeJson(pass->reads);
    store["first_pass"]["level"] = pass->level;
  }
  report["store"] = std::move(store);
}

void printStore(const StoredReads& reads, bool is_distant) {
  if (is_distant) say("asks the server for {} chunks: {}\n", reads.chunks, requestsText(reads));
  // Uncompressed chunks are not decoded, and nothing is said of them.
  if (reads.chunks == 0 || reads.decodes <= 0) return;
  if (reads.decodes <= reads.chunks) {
    say("decodes {} chunks, each once\n", reads.chunks);
  } else {
    say("decodes {} chunks up to {} times in all: decoded, they take {} of memory, which --memory "
        "does not leave to them\n",
        reads.chunks, reads.decodes, formatBytes(reads.decoded_bytes));
  }
}

}  // namespace sluice
