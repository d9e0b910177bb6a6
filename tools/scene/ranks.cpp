#include "tools/scene/ranks.h"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/base/threads/threads.h"
#include "src/library/drawing/scene/resources.h"
#include "tools/command_line/console.h"
#include "tools/command_line/environment.h"
#include "tools/command_line/interrupt.h"
#include "tools/commands/commands.h"
#include "tools/scene/processors.h"

namespace sluice {
namespace {

using nlohmann::json;
using nlohmann::literals::operator""_json_pointer;

// The host and the processors of this process: ranks with the same text share them.
std::string placeOfProcess() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  std::string place = host.data();
  for (const int processor : processorsOfProcess()) place += fmt::format(" {}", processor);
  return place;
}

std::string hostOf(const std::string& place) {
  return place.substr(0, place.find(' '));
}

int endTogether(Team& team, const std::string& line) {
  if (team.isFirst()) printError(line);
  team.finish();
  return kFailed;
}

// `status` if all ranks fail for this reason.
int failTogether(Team& team, const std::string& line, int status) {
  const std::string all = team.fail(line).what();
  const int failed = endTogether(team, all);
  // The same complaint from all is wrong usage; another one tells of a rank that failed.
  return all == line ? status : failed;
}

}  // namespace

Launch beginRanks() {
  const Launch launch = launchOfProcess();
  // The others print nowhere, since the first prints for all.
  if (launch.rank == 0) return launch;
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) return launch;
  dup2(nowhere, STDOUT_FILENO);
  close(nowhere);
  return launch;
}

int onRanks(const std::function<int(Team* team)>& body) {
  const Launch launch = launchOfProcess();
  if (launch.ranks == 1) return body(nullptr);
  Team team(joinRanks(launch), interruption());
  std::string reason;
  int status_of_all = kFailed;
  try {
    const int status = body(&team);
    team.wait();  // also for failures of others
    team.finish();
    return status;
  } catch (const RankFailed& failed) {
    return endTogether(team, failed.what());
  } catch (const Interrupted&) {
    throw;
  } catch (const std::bad_alloc&) {
    reason = "out of memory; give a smaller --memory or a larger machine";
  } catch (const CLI::ParseError& error) {
    reason = error.what();
    status_of_all = kUsage;
  } catch (const std::exception& error) {
    reason = error.what();
  }
  return failTogether(team, reason, status_of_all);
}

int refuseTogether(const Launch& launch, const std::string& line, int status) {
  if (launch.ranks > 1) {
    try {
      // All ranks may have refused, each for itself: they meet, so that one line is printed.
      Team team(joinRanks(launch), interruption());
      return failTogether(team, line, status);
    } catch (const std::exception&) {
      // Ranks that cannot meet: each refuses alone.
    }
  }
  if (launch.rank == 0) printError(line);
  return status;
}

void shareMachine(Team& team, ResourceArguments& resources) {
  const std::string place = placeOfProcess();
  const auto on_host = static_cast<uint64_t>(team.ranksBeside(hostOf(place)));
  const int on_processors = team.ranksBeside(place);
  // Ranks on one host share its memory, and those on the same processors these.
  if (resources.memory_bytes == 0) resources.memory_bytes = memoryBudget(resources) / on_host;
  if (resources.threads == 0) resources.threads = std::max(1, processorCount() / on_processors);
  if (!team.isFirst()) resources.quiet = true;
}

json rankJson(const json& report, const CompositingReport& parts) {
  json rank{
      {"part_bytes", parts.part_bytes},           {"sent_bytes", parts.sent_bytes},
      {"received_bytes", parts.received_bytes},   {"exchange_seconds", parts.exchange_seconds},
      {"compose_seconds", parts.compose_seconds}, {"gather_seconds", parts.gather_seconds}};
  for (const char* name : {"frames", "channels", "levels", "memory_bytes", "part_memory_bytes",
                           "peak_rss_bytes", "peak_anonymous_bytes", "device"})
    if (report.contains(name)) rank[name] = report[name];
  rank["host"] = hostOf(placeOfProcess());
  return rank;
}

void gatherReport(Team& team, const CompositingReport& parts, json& report) {
  const std::string mine = rankJson(report, parts).dump();
  const std::vector<Message> all = team.gather(asMessage(mine));
  if (!team.isFirst()) return;
  json ranks = json::array();
  for (const Message& message : all) {
    ranks.push_back(json::parse(asText(message)));
    ranks.back()["rank"] = ranks.size() - 1;
  }
  const auto sumUp = [&](json& to, const auto& of) {
    uint64_t sum = 0;
    for (const json& rank : ranks) sum += of(rank).template get<uint64_t>();
    to = sum;
  };
  // `at`: of a frame, or of one of its channels, in the report of each rank.
  const auto sumUpWork = [&](const json::json_pointer& at) {
    json& work = report[at];
    for (const char* kind : {"grey", "black"})
      sumUp(work["blocks"][kind], [&](const json& rank) { return rank[at]["blocks"][kind]; });
    for (const char* name :
         {"samples_drawn", "samples_taken", "samples_object", "boxes_drawn", "chunks", "pages",
          "pages_loaded", "decoded_bytes", "copied_bytes", "uploaded_bytes"})
      if (work.contains(name)) sumUp(work[name], [&](const json& rank) { return rank[at][name]; });
  };
  for (size_t i = 0; i < report["frames"].size(); ++i) {
    const json::json_pointer frame = "/frames"_json_pointer / i;
    sumUpWork(frame);
    if (!report[frame].contains("channels")) continue;
    for (size_t c = 0; c < report[frame]["channels"].size(); ++c) sumUpWork(frame / "channels" / c);
  }
  if (!report["frames"].empty()) report["blocks"] = report["frames"].back()["blocks"];
  const auto sumUpReads = [&](const json::json_pointer& at) {
    sumUp(report[at], [&](const json& rank) { return rank[at]; });
  };
  sumUpReads("/levels/disk/read_bytes"_json_pointer);
  if (report.contains("channels"))
    for (size_t c = 0; c < report["channels"].size(); ++c)
      sumUpReads("/channels"_json_pointer / c / "read_bytes");
  report["ranks"] = std::move(ranks);
}

}  // namespace sluice
