// sluice bench ranks: the gain from sharing a picture among ranks. Started by mpirun it measures
// that run's ranks; alone it has ranks of threads, each with a thread, a device and a budget of its
// own, and one process with one thread to compare with.
#include <algorithm>
#include <sstream>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"
#include "src/parallel/communication/in_process.h"
#include "src/parallel/communication/team.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/parse.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/rank_agreement.h"
#include "tools/scene/ranks.h"

namespace sluice {
namespace {

using nlohmann::json;

struct RanksBench : BenchArguments {
  std::vector<int> ranks = {1, 2};  // alone
};

// The frames of one rank, or of one process alone.
json framesOf(const RanksBench& bench, Team* team) {
  std::optional<Scene> scene;
  const auto open = [&] {
    scene.emplace(
        openScene(bench.volume, bench.look, bench.resources, bench.frame, Outputs(), team));
  };
  // One rank opens first: the others find its index on the disk and need not make one each.
  if (team == nullptr || team->isFirst()) open();
  if (team != nullptr) team->wait();
  if (!scene) open();
  if (team == nullptr) warnOfIdle(bench, *scene, bench.frame);
  FrameOptions options = bench.frame;
  options.stop = interruption();
  std::vector<double> seconds, draws, exchanges, composes, gathers;
  for (int i = 0; i < bench.frames + kWarmFrames; ++i) {
    options.camera.azimuth_deg = bench.frame.camera.azimuth_deg + 360.0 * i / bench.frames;
    scene->setOptions(options);
    // All start together, or the slowest rank of the frame before would count here.
    if (team != nullptr) team->wait();
    const Stopwatch watch;
    Frame frame = scene->frame();
    if (i < kWarmFrames) continue;
    seconds.push_back(watch.seconds());
    draws.push_back(frame.report.seconds);
    if (!scene->share) continue;
    const CompositingReport& parts = scene->composited;
    exchanges.push_back(parts.exchange_seconds);
    composes.push_back(parts.compose_seconds);
    gathers.push_back(parts.gather_seconds);
  }
  json row{{"ranks", team == nullptr ? 1 : team->ranks()},
           {"threads", scene->pool.threads()},
           {"frame_seconds",
            {{"median", median(seconds)},
             {"min", *std::min_element(seconds.begin(), seconds.end())},
             {"max", *std::max_element(seconds.begin(), seconds.end())}}},
           {"draw_seconds", median(draws)}};
  if (!scene->share) return row;
  row["exchange_seconds"] = median(exchanges);
  row["compose_seconds"] = median(composes);
  row["gather_seconds"] = median(gathers);
  row["part_bytes"] = scene->composited.part_bytes;
  row["sent_bytes"] = scene->composited.sent_bytes;
  row["hand_blocks"] = scene->share->dealing().hand;
  return row;
}

// `rows` [{`ranks`, `frame_seconds`{`median`,`min`,`max`}, `draw_seconds`, `exchange_seconds`,
// `compose_seconds`, `gather_seconds`, `part_bytes`, `sent_bytes`, `speedup`}]: medians of rank 0,
// speedup against the row of one. `team` is null for a single process. Throws Error. With several
// ranks, rank 0 gets the report.
json benchRanks(const RanksBench& asked, Team* team) {
  RanksBench bench = asked;
  json rows = json::array();
  if (team != nullptr) {
    shareMachine(*team, bench.resources);
    rows.push_back(framesOf(bench, team));
    return {{"rows", rows}};
  }
  bench.resources.threads = 1;
  const uint64_t memory_bytes = memoryBudget(bench.resources);
  for (const int ranks : bench.ranks) {
    bench.resources.memory_bytes = memory_bytes / static_cast<uint64_t>(ranks);
    json row;
    if (ranks == 1) {
      row = framesOf(bench, nullptr);
    } else {
      const auto ends = runInProcess(
          ranks,
          [&](Team& one) {
            json of_one = framesOf(bench, &one);
            if (one.isFirst()) row = std::move(of_one);
          },
          interruption());
      if (!ends[0].empty()) fail("{}", ends[0]);
    }
    rows.push_back(std::move(row));
  }
  for (json& row : rows)
    if (rows[0]["ranks"] == 1)
      row["speedup"] = rows[0]["frame_seconds"]["median"].get<double>() /
                       row["frame_seconds"]["median"].get<double>();
  return {{"rows", rows}};
}

void printRanks(const json& report) {
  say("{:>6} {:>10} {:>9} {:>12} {:>11} {:>10} {:>10} {:>8}\n", "ranks", "frame ms", "draw ms",
      "exchange ms", "compose ms", "gather ms", "sent", "speedup");
  const auto milliseconds = [](const json& row, const char* name) {
    return row.contains(name) ? fmt::format("{:.2f}", 1e3 * row[name].get<double>())
                              : std::string("-");
  };
  for (const json& row : report["rows"])
    say("{:>6} {:>10.2f} {:>9} {:>12} {:>11} {:>10} {:>10} {:>8}\n", row["ranks"].get<int>(),
        1e3 * row["frame_seconds"]["median"].get<double>(), milliseconds(row, "draw_seconds"),
        milliseconds(row, "exchange_seconds"), milliseconds(row, "compose_seconds"),
        milliseconds(row, "gather_seconds"),
        row.contains("sent_bytes") ? formatBytes(row["sent_bytes"].get<uint64_t>()) : "-",
        row.contains("speedup") ? fmt::format("{:.2f}", row["speedup"].get<double>()) : "-");
}

// "1,2,4".
std::optional<std::vector<int>> rankCounts(const std::string& word) {
  constexpr int kMostRanks = 64;
  return parseList<int>(word, [](const std::string& part) {
    return parseIn<int>(part, {1, kMostRanks});
  });
}

}  // namespace

Bench addRanksBench(CLI::App& app) {
  auto bench = std::make_shared<RanksBench>();
  bench->frame = plainFrame();
  CLI::App* ranks =
      app.add_subcommand("ranks",
                         "Measures pictures shared among ranks: those of mpirun, or in-process "
                         "ranks of one thread each\n\n"
                         "  mpirun -n 2 sluice bench ranks bonsai.nii.gz --threshold 40");
  addPictures(*ranks, *bench);
  const OptionGroup output(*ranks, kOutputHeading);
  output.parsed(
      "--ranks", "N,...", "numbers from 1 to 64 with commas between", rankCounts,
      [bench](const std::vector<int>& counts) { bench->ranks = counts; },
      "Ranks to measure if no launcher sets their number", "1,2");
  addFramesOption(output, bench->frames, kFrames);
  return {ranks,
          [bench, ranks](const Show& show) {
            return onRanks([&](Team* team) {
              if (team != nullptr) expectSameCommand(*team, *ranks);
              return show(benchRanks(*bench, team), printRanks);
            });
          },
          true};
}

}  // namespace sluice
