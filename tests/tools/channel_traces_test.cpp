// Traces of several channels, recorded by the renderer and planned by the simulator.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/tools/channels_fixture.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// A scene of several channels, and the names of their traces for t.bin.
struct TracedScene {
  std::string options;
  std::vector<std::string> traces;
};
const std::vector<TracedScene> kTracedScenes = {
    {"cells.ome.zarr --over flat.ome.zarr", {"t_0.bin", "t_1.bin", "t_2.bin", "t_over.bin"}},
    {"cells.ome.zarr --combine blend", {"t_0.bin", "t_1.bin", "t_2.bin"}},
    {"eight.ome.zarr --channel 0,1 --over flat.ome.zarr --combine blend --projection perspective",
     {"t_0.bin", "t_1.bin", "t_over.bin"}}};
constexpr const char* kTracedMachine =
    " --frames 4 --size 60x50 --block 16 --page 16x16x4 --pages 32 ";

// The counters of the row are those of the renderer's cache, whose uploads are those of a device
// that copies.
void expectCounters(const nlohmann::json& row, const nlohmann::json& cache, bool copies) {
  EXPECT_EQ(row["chunk_requests"], cache["requests"]);
  EXPECT_EQ(row["chunk_misses"], cache["misses"]);
  EXPECT_EQ(row["evictions"], cache["evictions"]);
  EXPECT_EQ(row["pages_loaded"], cache["pages_loaded"]);
  EXPECT_EQ(cache["uploaded_bytes"], copies ? row["bytes_moved"] : nlohmann::json(0));
}

// Each channel has a cache of its own share, and the simulator's numbers are its real uploads.
TEST_F(Channels, tracesOfChannelsCostWhatTheRendererUploadedForEach) {
  for (const std::string device : {"cpu", "gl --gl osmesa"})
    for (const TracedScene& scene : kTracedScenes) {
      SCOPED_TRACE(device + " " + scene.options);
      const CommandResult drawn =
          program_.run("render " + scene.options + kTracedMachine +
                       "-o t.png --force --trace t.bin --report r.json --device " + device);
      if (drawn.status != 0 && device != "cpu") GTEST_SKIP() << "no software OpenGL";
      ASSERT_EQ(drawn.status, 0) << drawn.output;
      const auto report = nlohmann::json::parse(readFile(program_.folder / "r.json"));
      ASSERT_EQ(report["channels"].size(), scene.traces.size());
      nlohmann::json sum = nlohmann::json::object();
      for (size_t i = 0; i < scene.traces.size(); ++i) {
        SCOPED_TRACE(scene.traces[i]);
        const auto& cache = report["channels"][i]["levels"]["texture_cache"];
        const std::string pages = std::to_string(cache["pages"].get<int64_t>());
        const auto rows =
            program_.json(fmt::format("simulate {} --policies lru --sizes {} --pages {}",
                                      scene.traces[i], pages, pages))["rows"];
        ASSERT_EQ(rows.size(), 1);
        expectCounters(rows[0], cache, device != "cpu");
        EXPECT_GT(cache["evictions"].get<int64_t>() + cache["hits"].get<int64_t>(), 0);
        for (const char* key :
             {"requests", "misses", "evictions", "pages_loaded", "uploaded_bytes"})
          sum[key] = sum.value(key, int64_t{0}) + cache[key].get<int64_t>();
      }
      for (const auto& [key, value] : sum.items())
        EXPECT_EQ(report["levels"]["texture_cache"][key], value) << key;
      EXPECT_FALSE(program_.exists("t.bin"));
    }
}

// The simulator plans the requests of each channel as the renderer makes them: the same traces,
// with the same misses, evictions and uploads in caches of the same size, which the sum adds up.
TEST_F(Channels, aPlannedTurnIsWhatTheRendererUploadsForEach) {
  for (const std::string device : {"cpu", "gl --gl osmesa"})
    for (const TracedScene& scene : kTracedScenes)
      for (const std::string machine : {"--pages 32", "--pages 128", "--memory 60M"}) {
        SCOPED_TRACE(device + " " + scene.options + " " + machine);
        const std::string command =
            scene.options + " --frames 4 --size 60x50 --block 16 --page 16x16x4 --force --zoom 2 " +
            machine + " --policy sieve ";
        const CommandResult drawn =
            program_.run("render " + command +
                         "-o t.png --force --trace t.bin --report r.json --device " + device);
        if (drawn.status != 0 && device != "cpu") GTEST_SKIP() << "no software OpenGL";
        ASSERT_EQ(drawn.status, 0) << drawn.output;
        const auto report = nlohmann::json::parse(readFile(program_.folder / "r.json"));
        const bool has_pages = machine.starts_with("--pages");
        const auto simulated = program_.json(
            "simulate " + command + "--policies sieve --export p.bin " +
            (has_pages ? "--sizes " + machine.substr(std::string_view("--pages ").size()) : ""));
        size_t checked = 0;
        for (size_t i = 0; i < scene.traces.size(); ++i) {
          SCOPED_TRACE(scene.traces[i]);
          const auto& channel = report["channels"][i];
          const auto& cache = channel["levels"]["texture_cache"];
          EXPECT_EQ(simulated["runs"][i]["channel"], channel["channel"]);
          EXPECT_EQ(simulated["runs"][i]["chosen"]["pages"], cache["pages"]);
          for (const auto& row : simulated["rows"]) {
            if (row["channel"] != channel["channel"] || row["pages"] != cache["pages"]) continue;
            ++checked;
            EXPECT_EQ(row["planned_pages"], row["pages"]);
            expectCounters(row, cache, device != "cpu");
          }
          std::string planned = scene.traces[i];
          planned.front() = 'p';
          EXPECT_TRUE(readFile(program_.folder / planned) ==
                      readFile(program_.folder / scene.traces[i]));
        }
        EXPECT_EQ(checked, scene.traces.size());
        const auto& all = report["levels"]["texture_cache"];
        const auto sum = std::ranges::find_if(
            simulated["sum"], [&](const auto& row) { return row["pages"] == all["pages"]; });
        ASSERT_NE(sum, simulated["sum"].end());
        expectCounters(*sum, all, device != "cpu");
        EXPECT_EQ((*sum)["channel"], "sum");
      }
}

// Each channel has its rows, in the table, the JSON and the CSV, and one channel has no label.
TEST_F(Channels, simulatedChannelsAreTold) {
  const std::string options = "--frames 2 --size 60x50 --policies lru,fifo --sizes 64,128 ";
  const CommandResult table =
      program_.run("simulate cells.ome.zarr --channel 2,Actin --csv t.csv " + options);
  EXPECT_EQ(table.status, 0);
  for (const char* title :
       {"cells.ome.zarr, channel 2 (Spots)\n", "channel 1 (Actin)\n", "\nall channels together\n"})
    EXPECT_THAT(table.output, HasSubstr(title));
  const std::string csv = readFile(program_.folder / "t.csv");
  EXPECT_THAT(csv, HasSubstr(",miss_ratio,channel\n"));
  for (const char* ending : {",2\n", ",1\n", ",sum\n"}) {
    size_t rows = 0;
    for (size_t at = csv.find(ending); at != std::string::npos; at = csv.find(ending, at + 1))
      ++rows;
    EXPECT_EQ(rows, 4) << ending;
  }
  const auto two = program_.json("simulate cells.ome.zarr --channel 2,Actin " + options);
  const auto over =
      program_.json("simulate cells.ome.zarr --channel 2 --over flat.ome.zarr " + options);
  EXPECT_EQ(two["rows"].size(), 8);
  EXPECT_EQ(two["sum"].size(), 4);
  EXPECT_EQ(over["rows"][4]["channel"], "over");
  for (size_t i = 0; i < 4; ++i)
    for (const char* key : {"requests", "hits", "misses", "bytes_moved", "pages"})
      EXPECT_EQ(two["sum"][i][key],
                two["rows"][i][key].get<int64_t>() + two["rows"][i + 4][key].get<int64_t>());
  const auto one = program_.json("simulate cells.ome.zarr --channel 1 " + options);
  EXPECT_FALSE(one.contains("sum"));
  EXPECT_FALSE(one["rows"][0].contains("channel"));
}

// The page of several channels ends with the table of their sum; one channel has none.
TEST_F(Channels, simulationPageHasTheirSum) {
  const std::string options = " --frames 2 --size 60x50 --policies lru,fifo --sizes 64,128 ";
  const auto page = [&](const std::string& more) {
    const CommandResult run =
        program_.run("simulate cells.ome.zarr --html p.html --force " + more + options);
    EXPECT_EQ(run.status, 0) << run.output;
    return readFile(program_.folder / "p.html");
  };
  const auto json = program_.json("simulate cells.ome.zarr --channel 2,Actin " + options);
  const std::string two = page("--channel 2,Actin");
  const size_t at = two.find("<h2>All channels together</h2>");
  ASSERT_NE(at, std::string::npos);
  EXPECT_LT(two.rfind("<h2>", at - 1), at);
  for (const auto& row : json["sum"])
    EXPECT_THAT(two.substr(at),
                HasSubstr(fmt::format("<td>{}<td>{}<td>{}<td>", row["requests"].get<int64_t>(),
                                      row["hits"].get<int64_t>(), row["misses"].get<int64_t>())));
  EXPECT_EQ(page("--channel 2").find("All channels together"), std::string::npos);
  const std::string sizes = page("--channel 2,Actin --page 16x16x16,32x32x4");
  EXPECT_THAT(sizes, HasSubstr("<h2>All channels together, pages of 32x32x4</h2>"));
}

// The channel stands before the extension. A name that cannot be written is refused as it was
// given.
TEST_F(Channels, tracesAreNamedByTheirChannel) {
  const auto draw = [&](const std::string& trace) {
    return program_.run("render cells.ome.zarr --size 30x20 --force -o a.png --trace " + trace);
  };
  for (const auto& [asked, first] :
       {std::pair("a.txt", "a_0.txt"), std::pair("b", "b_0"), std::pair("c.d.txt", "c.d_0.txt"),
        std::pair("./.txt", ".txt_0")}) {
    const CommandResult drawn = draw(asked);
    EXPECT_EQ(drawn.status, 0) << drawn.output;
    EXPECT_TRUE(program_.exists(first)) << asked;
  }
  const CommandResult refused = draw("e.txt.gz");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output, HasSubstr("sluice: e.txt.gz: compressed traces are read, not "
                                        "written; name it e.txt and compress it afterwards"));
}

TEST_F(Channels, tracesReplaceOnlyTraces) {
  std::ofstream(program_.folder / "t_1.txt") << "mine";
  const std::string command = "render cells.ome.zarr --size 60x50 -o a.png --trace t.txt";
  const CommandResult refused = program_.run(command);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.output, HasSubstr("--trace t_1.txt: exists and is not a trace"));
  EXPECT_EQ(readFile(program_.folder / "t_1.txt"), "mine");
  EXPECT_FALSE(program_.exists("t_0.txt"));
  EXPECT_EQ(program_.run(command + " --force").status, 0);
  EXPECT_EQ(program_.run(command).status, 0) << "a trace replaces a trace";
  EXPECT_THAT(readFile(program_.folder / "t_1.txt"), StartsWith("sluice-trace 1"));
  EXPECT_THAT(
      program_.run("render cells.ome.zarr -o a.png --trace t.txt --report t_0.txt --force").output,
      HasSubstr("is the same file as"));
}

}  // namespace
}  // namespace sluice
