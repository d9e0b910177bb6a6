// sluice bench channels: a picture of several channels, added and blended, beside each of them
// alone.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/library/opening/channel_looks.h"
#include "src/library/opening/shown_channels.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/outputs/report.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

using nlohmann::json;

// The frames of one row of the report, from a scene of their own.
struct ChannelsWay {
  std::string name;
  Scene scene;
  std::vector<double> cpu_s, wall_s;
};

// The same frames of a volume with this look, in a part of the memory.
ChannelsWay wayOf(const BenchArguments& bench, std::string name, const VolumeArguments& volume,
                  const LookArguments& look, uint64_t parts) {
  ResourceArguments resources = bench.resources;
  resources.memory_bytes = memoryBudget(resources) / parts;
  return {std::move(name), openScene(volume, look, resources, bench.frame), {}, {}};
}

void measure(ChannelsWay& way, const FrameOptions& options) {
  way.scene.setOptions(options);
  const double before_s = processorSeconds();
  const Stopwatch watch;
  way.scene.frame();
  way.wall_s.push_back(watch.seconds());
  way.cpu_s.push_back(processorSeconds() - before_s);
}

// A line for each option that changes nothing in all ways, and in one of them.
void warnOfIdle(const BenchArguments& bench, const std::vector<ChannelsWay>& ways) {
  std::map<std::string, std::vector<std::string>> ways_of;  // by line
  for (const ChannelsWay& way : ways)
    for (const std::string& line : idleLines(bench, way.scene, bench.frame, {"--combine"}))
      ways_of[line].push_back(way.name);
  for (const auto& [line, names] : ways_of)
    printWarning(names.size() == ways.size()
                     ? line
                     : fmt::format("{} (in {})", line, fmt::join(names, ", ")));
}

json benchChannels(const BenchArguments& bench) {
  const std::vector<ChannelSource> channels = openChannels(bench.volume);
  if (channels.size() < 2 || channels.back().channel.is_over)
    failRequest(
        "{}: bench channels measures several channels of one volume, as --channel 0,1 gives them",
        bench.volume.inputs.front());
  // All ways are open at once: together they stay within --memory.
  const uint64_t parts = channels.size() + 2;
  std::vector<ChannelsWay> ways;
  ways.reserve(parts);
  for (const ChannelSource& each : channels)
    ways.push_back(wayOf(bench, each.channel.id(), each.arguments,
                         lookOfChannel(bench.look, each.channel), parts));
  LookArguments look = bench.look;
  for (const auto& [name, combine] :
       {std::pair("add", Combine::kAdd), {"blend", Combine::kBlend}}) {
    look.combine = combine;
    ways.push_back(wayOf(bench, name, bench.volume, look, parts));
  }
  warnOfIdle(bench, ways);
  for (int i = -kWarmFrames; i < bench.frames; ++i) {
    FrameOptions options = bench.frame;
    options.camera.azimuth_deg += 360.0 * std::max(i, 0) / bench.frames;
    // The ways take turns, so that a busy machine slows down all of them alike.
    for (ChannelsWay& way : ways) {
      measure(way, options);
      if (i >= 0) continue;
      way.cpu_s.clear();
      way.wall_s.clear();
    }
  }
  double of_one = 0;
  json rows = json::array();
  for (const ChannelsWay& way : ways) {
    const double cpu_s = median(way.cpu_s);
    if (rows.size() < channels.size()) of_one += cpu_s / static_cast<double>(channels.size());
    rows.push_back(
        {{"way", way.name}, {"seconds", median(way.wall_s)}, {"processor_seconds", cpu_s}});
  }
  for (json& row : rows) row["ratio"] = row["processor_seconds"].get<double>() / of_one;
  return {{"volume", ways.front().scene.volume.name},
          {"rows", rows},
          {"device", nameOf(*ways.front().scene.device)}};
}

void printChannels(const json& report) {
  say("{:>8} {:>8} {:>8} {:>6}\n", "channel", "CPU ms", "ms", "ratio");
  for (const json& row : report["rows"])
    say("{:>8} {:>8.1f} {:>8.1f} {:>6.2f}\n", row["way"].get<std::string>(),
        1000 * row["processor_seconds"].get<double>(), 1000 * row["seconds"].get<double>(),
        row["ratio"].get<double>());
  say("ratio: of the processor's time, to the mean of the channels alone\n");
}

}  // namespace

Bench addChannelsBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  CLI::App* channels = app.add_subcommand(
      "channels",
      "What several channels cost: frames of a turn of each channel alone, of all of them added, "
      "and blended as one medium (--combine), drawn by turns. Each way has its share of --memory."
      "\n\nExample:\n  sluice bench channels cells.ome.zarr --channel 0,1,2 --no-shade");
  addFrames(*channels, *bench, kFramesOfEachWay);
  return {channels,
          [bench](const Show& show) { return show(benchChannels(*bench), printChannels); }, true};
}

}  // namespace sluice
