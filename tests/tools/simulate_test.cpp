#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/tools/program.h"
#include "tests/tools/skewed_trace.h"

namespace sluice {
namespace {

constexpr const char* kMachine = " --page 16x16x4 --block 16 --pages 64 --policy ";

// Design, point 5: the simulated I/O of a turn equals the real one, byte for byte. A device that
// copies gets the simulator's bytes; a device that borrows copies none, and its pages move in the
// model just the same.
void expectMovesOf(const nlohmann::json& row, const nlohmann::json& report) {
  const auto& cache = report["levels"]["texture_cache"];
  const bool copies = report["options"]["device"] == "gl";
  EXPECT_EQ(cache["uploaded_bytes"], copies ? row["bytes_moved"] : nlohmann::json(0));
  EXPECT_EQ(row["pages_loaded"], cache["pages_loaded"]);
  EXPECT_EQ(row["chunk_requests"], cache["requests"]);
  EXPECT_EQ(row["chunk_misses"], cache["misses"]);
  EXPECT_EQ(row["evictions"], cache["evictions"]);
}

TEST(Simulate, theRenderersTraceCostsExactlyWhatTheRendererUploaded) {
  const Program program;
  for (const std::string device : {"gl", "cpu"})
    for (const std::string policy : {"lru", "arc", "sieve", "fifo"}) {
      SCOPED_TRACE(device + " " + policy);
      const CommandResult drawn =
          program.run(std::string("render ") + kSmall + kMachine + policy + " --device " + device +
                      " -o t.png --frames 5 --size 32 --trace t.bin --report r.json");
      ASSERT_EQ(drawn.status, 0) << drawn.output;
      const auto rows = program.json("simulate t.bin --sizes 64 --pages 64 --policies " + policy +
                                     " --policy " + policy)["rows"];
      ASSERT_EQ(rows.size(), 1U);
      expectMovesOf(rows[0], nlohmann::json::parse(readFile(program.folder / "r.json")));
      EXPECT_GT(rows[0]["bytes_moved"].get<int64_t>(), 0);
      EXPECT_EQ(rows[0]["requests"].get<int64_t>(),
                rows[0]["hits"].get<int64_t>() + rows[0]["misses"].get<int64_t>());
    }
}

TEST(Simulate, aPlannedTurnIsTheTraceOfTheDrawnOne) {
  const Program program;
  const std::string common =
      std::string(kSmall) + kMachine + "lru --frames 4 --azimuth 15 --elevation 25 ";
  ASSERT_EQ(program.run("render " + common + "-o t.png --size 32 --trace drawn.txt").status, 0);
  ASSERT_EQ(
      program.run("simulate " + common + "--sizes 64 --policies lru --export planned.txt").status,
      0);
  EXPECT_EQ(readFile(program.folder / "drawn.txt"), readFile(program.folder / "planned.txt"));
}

// The ninth number of each line of a text trace, 0 where there are eight.
std::set<int> levelsOfTrace(const std::filesystem::path& path) {
  std::ifstream lines(path);
  std::set<int> levels;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::vector<int64_t> numbers;
    for (int64_t number = 0; words >> number;) numbers.push_back(number);
    if (numbers.size() >= 8) levels.insert(numbers.size() > 8 ? static_cast<int>(numbers[8]) : 0);
  }
  return levels;
}

// The cut of each view follows from the view, so both are given the size of the picture.
TEST(Simulate, aTurnThroughLevelsOfResolutionMovesWhatTheRendererMoves) {
  const Program program;
  const std::string common =
      std::string("synth:shells,dims=120x110x100,levels=4 --threshold 60") + kMachine +
      "lru --frames 4 --size 40 --projection perspective --zoom 3 --pixel-error 2 ";
  for (const std::string device : {"gl", "cpu"}) {
    const nlohmann::json drawn = program.json("render " + common + "--device " + device +
                                              " -o t.png --force --trace drawn.txt");
    EXPECT_GE(drawn["cut"]["levels"].size(), 2U);
    const auto rows = program.json(
        "simulate " + common + "--sizes 64 --policies lru --export planned.txt --force")["rows"];
    EXPECT_EQ(readFile(program.folder / "drawn.txt"), readFile(program.folder / "planned.txt"));
    ASSERT_EQ(rows.size(), 1U);
    expectMovesOf(rows[0], drawn);
    // The recorded trace costs the same, and names the level of each chunk.
    expectMovesOf(
        program.json("simulate drawn.txt --sizes 64 --pages 64 --policies lru")["rows"][0], drawn);
    const std::set<int> levels = levelsOfTrace(program.folder / "drawn.txt");
    for (const auto& level : drawn["cut"]["levels"])
      EXPECT_TRUE(levels.contains(level["level"].get<int>())) << level;
    EXPECT_LT(*levels.rbegin(), 4);
  }
}

// The table's row for N pages equals what the renderer does with a cache of N pages, whatever
// --pages is: each size has its own plan.
TEST(Simulate, eachSizeIsPlannedAsTheRendererPlansIt) {
  const Program program;
  const std::string scene = std::string(kSmall) + " --page 16x16x4 --block 16 --frames 4";
  const auto rows = program.json("simulate " + scene +
                                 " --pages 64 --sizes 8,16,64,512 --policies lru,sieve")["rows"];
  ASSERT_EQ(rows.size(), 8U);
  std::set<int64_t> requests;
  for (const auto& row : rows) {
    const std::string pages = std::to_string(row["pages"].get<int64_t>());
    SCOPED_TRACE(pages);
    EXPECT_EQ(row["planned_pages"], row["pages"]);
    const CommandResult drawn =
        program.run("render " + scene + " --device gl --pages " + pages + " --policy " +
                    row["policy"].get<std::string>() + " -o t.png --size 32 --report r.json");
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    expectMovesOf(row, nlohmann::json::parse(readFile(program.folder / "r.json")));
    requests.insert(row["chunk_requests"].get<int64_t>());
  }
  EXPECT_GT(requests.size(), 1U);  // or the test could not tell
}

TEST(Simulate, aFixedPlanIsThatOfItsPagesAtEverySize) {
  const Program program;
  const std::string scene = std::string(kSmall) + " --page 16x16x4 --block 16 --frames 3 ";
  const auto rows = program.json(
      "simulate " + scene + "--pages 64 --fixed-plan --sizes 16,64,512 --policies lru")["rows"];
  const auto planned = program.json("simulate " + scene + "--sizes 64 --policies lru")["rows"][0];
  ASSERT_EQ(rows.size(), 3U);
  for (const auto& row : rows) {
    EXPECT_EQ(row["planned_pages"], 64);
    EXPECT_EQ(row["chunk_requests"], planned["chunk_requests"]);
  }
  EXPECT_EQ(rows[1], planned);
}

// A trace goes out in each format and comes back: the same table, clusters pinned.
TEST(Simulate, anExportedTraceGivesTheNumbersOfTheTraceItself) {
  const Program program;
  ASSERT_EQ(program
                .run(std::string("render ") + kSmall + kMachine +
                     "lru -o t.png --frames 5 --size 32 --trace t.bin")
                .status,
            0);
  const auto rows = program.json("simulate t.bin --sizes 8,16,64,100");
  EXPECT_EQ(rows["pinned"], true);
  EXPECT_EQ(rows["rows"].size(), 4 * 16U);
  for (const std::string file : {"u.txt", "u.csv", "u.oracleGeneral", "u.din", "u.bin"}) {
    ASSERT_EQ(program.run("simulate t.bin --sizes 64 --policies lru --export " + file).status, 0);
    const auto back = program.json("simulate " + file + " --sizes 8,16,64,100");
    EXPECT_EQ(back["rows"], rows["rows"]) << file;
    EXPECT_EQ(back["pinned"], true) << file;
    EXPECT_EQ(back["page_bytes"], rows["page_bytes"]);
  }
  EXPECT_EQ(program.json("simulate t.bin --sizes 64 --pin off")["pinned"], false);
}

// All requests of a time stamp are no cluster: nothing of others' traces is pinned.
TEST(Simulate, othersTracesAreNotPinned) {
  const Program program;
  std::string csv = "time,obj_id,obj_size\n", din;
  for (int i = 0; i < 600; ++i) {
    csv += fmt::format("7,{},4096\n", i * 7 % 19);
    din += fmt::format("0 {:x}\n", i * 7 % 19 * 4096);
  }
  std::ofstream(program.folder / "t.csv") << csv;
  std::ofstream(program.folder / "t.din") << din;
  const auto rows = program.json("simulate t.csv --sizes 8 --policies lru,fifo,belady");
  EXPECT_EQ(rows["pinned"], false);
  EXPECT_EQ(rows["rows"],
            program.json("simulate t.din --sizes 8 --policies lru,fifo,belady")["rows"]);
  for (const auto& row : rows["rows"]) EXPECT_EQ(row["failures"], 0);
  EXPECT_NE(rows["rows"][0]["misses"], rows["rows"][2]["misses"]);
  EXPECT_EQ(rows["rows"][0]["planned_pages"], nullptr);
}

TEST(Simulate, failuresAreCountedAndMarked) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << "1,7,40960\n2,8,4096\n3,7,40960\n";
  const CommandResult table = program.run("simulate t.csv --sizes 4 --policies lru --csv rows.csv");
  EXPECT_NE(table.output.find("       2 !\n"), std::string::npos) << table.output;
  EXPECT_NE(table.output.find("! chunk requests that do not fit"), std::string::npos);
  const auto row = program.json("simulate t.csv --sizes 4 --policies lru")["rows"][0];
  EXPECT_EQ(row["failures"], 2);
  EXPECT_EQ(row["bytes_moved"], 2 * 40960 + 4096);
  EXPECT_NE(readFile(program.folder / "rows.csv").find(",86016,"), std::string::npos);
  EXPECT_EQ(program.run("simulate t.csv --sizes 16 --policies lru").output.find('!'),
            std::string::npos);
}

TEST(Simulate, sizesThatChangeAreReported) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << "1,7,4096\n2,7,9000\n3,7,4096\n";
  const CommandResult result = program.run("simulate t.csv --sizes 4 --policies lru 2>&1");
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.output.find("t.csv: 1 of 3 requests name another size"), std::string::npos)
      << result.output;
}

struct Refused {
  std::string arguments;
  int status;
  std::string said;
};

TEST(Simulate, refusesWhatItWouldDropOrCannotReplay) {
  const Program program;
  std::ofstream(program.folder / "a.csv") << "1,7,4096\n2,8,4096\n";
  std::ofstream(program.folder / "b.csv") << "1,7,4096\n";
  std::ofstream(program.folder / "empty.csv");
  std::ofstream(program.folder / "names.csv") << "time,obj_id,obj_size\n";
  std::ofstream(program.folder / "bad.csv") << "1,x,3\n1,2,3\n";
  std::ofstream(program.folder / "head.txt") << "sluice-trace 1 page_bytes 4096\n";
  std::ofstream(program.folder / "wide.txt")
      << "sluice-trace 1 page_bytes 4096\n1 2147483648 0 0 4096 0 0 0\n";
  ASSERT_EQ(runCommand("mkfifo " + (program.folder / "pipe").string()).status, 0);
  ASSERT_EQ(runCommand("mkdir " + (program.folder / "folder.csv").string()).status, 0);
  std::ofstream(program.folder / "empty.txt");
  std::ofstream(program.folder / "what.bin") << "neither a volume nor a trace";
  const std::string small = std::string("simulate ") + kSmall;
  const std::vector<Refused> cases{
      {"simulate a.csv b.csv --export u.bin", 2, "for one trace or page size at a time"},
      {"simulate a.csv pipe", 2, "traces can be combined with traces only"},
      {"simulate a.csv --csv - --json", 2, "both want the standard output"},
      {"simulate a.csv --sample 0.5 --policies lru", 2, "does not go with --sample"},
      {"simulate a.csv --sample 1.5", 2, "--sample"},
      {"simulate a.csv --sizes 10MB", 2, "--sizes"},
      {"simulate a.csv --sizes 1.5K", 2, "--sizes"},
      {"simulate a.csv --sizes 2T", 2, "--sizes"},
      {small + " --page 4x4x4,5x4x4", 2, "--page"},
      {"simulate a.csv --threshold 3", 2, "--threshold"},
      {"simulate a.csv --fixed-plan", 2, "--fixed-plan"},
      {small + " --page-bytes 4096", 2, "--page-bytes"},
      {small + " --format csv", 2, "--format: is for traces, and synth:shells"},
      {"simulate https://host/v.zarr --format csv", 2, "--format: is for traces"},
      {small + " --occlusion cull", 2, "--occlusion"},
      {small + " --time-limit 1", 2, "--time-limit"},
      {"simulate a.csv --prefetch sometimes", 2, "next-cluster"},
      {"simulate a.csv --policies mru", 2, "s3-fifo"},
      {"simulate a.csv --machine onyx", 2, "octane"},
      {"simulate a.csv --pin on", 2, "auto"},
      {"simulate a.csv --pages 4294967296", 2, "a power of two from 1 to 2147483648"},
      {"simulate a.csv --sizes 0", 2, "--sizes"},
      {"simulate a.csv --prefetch next-cluster", 1, "this trace carries none"},
      {"simulate empty.csv", 1, "empty.csv: the trace is empty: it holds no requests"},
      {"simulate names.csv", 1, "names.csv: the trace is empty: it holds no requests"},
      {"simulate head.txt", 1, "head.txt: the trace is empty: it holds no requests"},
      {"simulate empty.txt", 1, "nor a trace: text or binary of sluice, .csv, .oracleGeneral"},
      {"simulate what.bin", 1, "nor a trace: text or binary of sluice, .csv, .oracleGeneral"},
      {"simulate bad.csv", 1, "bad.csv:1: expected time,obj_id,obj_size"},
      {"simulate pipe", 1, "found a pipe"},
      {"simulate pipe --format csv", 1, "found a pipe"},
      {"simulate folder.csv", 1, "found a folder"},
      {"simulate wide.txt --by-page --memory 1G", 1, "--by-page needs"},
      {small + " --sizes 1 --block 16 --page 4x4x4", 1, "give --pages"},
  };
  for (const Refused& c : cases) {
    const CommandResult result = program.run(c.arguments + " 2>&1 < /dev/null");
    EXPECT_EQ(result.status, c.status) << c.arguments << ": " << result.output;
    EXPECT_NE(result.output.find(c.said), std::string::npos)
        << c.arguments << ": " << result.output;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  }
}

TEST(Simulate, aRequestOfTwoToThe31PagesIsReplayedAtOnce) {
  const Program program;
  std::ofstream out(program.folder / "wide.txt");
  out << "sluice-trace 1 page_bytes 4096\n";
  for (int i = 0; i < 500; ++i) out << i % 2 << " 2147483648 0 " << i << " 8796093022208 0 0 0\n";
  out.close();
  // 2^43 bytes a load exceed the limit of a record.
  EXPECT_NE(program.run("simulate wide.txt 2>&1").output.find("at most 2^40"), std::string::npos);
  out.open(program.folder / "wide.txt");
  out << "sluice-trace 1 page_bytes 4096\n";
  for (int i = 0; i < 500; ++i) out << i % 2 << " 2147483648 0 " << i << " 1099511627776 0 0 0\n";
  out.close();
  const CommandResult result =
      program.run("simulate wide.txt --pages 2147483648 --html r.html --export u.bin");
  EXPECT_EQ(result.status, 0) << result.output;
}

TEST(Simulate, writesItsTableAndAReportThatStandsAlone) {
  const Program program;
  ASSERT_EQ(program
                .run(std::string("simulate ") + kSmall + kMachine +
                     "lru --frames 3 --csv t.csv --html r.html --prefetch next-cluster")
                .status,
            0);
  EXPECT_EQ(readFile(program.folder / "t.csv").rfind("policy,pages,requests", 0), 0U);
  const std::string page = readFile(program.folder / "r.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  for (const char* outside : {"http://", "https://", "src=", "@import"})
    if (std::string(outside).rfind("http", 0) != 0) {
      EXPECT_EQ(page.find(outside), std::string::npos);
    }
}

TEST(Simulate, severalTracesAreOneTable) {
  const Program program;
  std::ofstream(program.folder / "a.csv") << skewedCsv(3000);
  std::ofstream(program.folder / "b, c.csv") << skewedCsv(200);
  const std::string options = " --sizes 16,64 --policies lru,lirs ";
  const auto both = program.json("simulate a.csv 'b, c.csv'" + options);
  auto expected = nlohmann::json::array();
  for (const std::string file : {"a.csv", "b, c.csv"}) {
    const auto alone = program.json("simulate '" + file + "'" + options);
    for (auto row : alone["rows"]) {
      row["trace"] = file;
      expected.push_back(row);
    }
  }
  EXPECT_EQ(both["rows"], expected);
  EXPECT_EQ(both["runs"].size(), 2U);
  EXPECT_EQ(both["runs"][1]["trace"], "b, c.csv");
  const std::string csv = program.run("simulate a.csv 'b, c.csv' --csv -" + options).output;
  EXPECT_NE(csv.find("planned_pages,miss_ratio,trace\n"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",\"b, c.csv\"\n"), std::string::npos) << csv;
  EXPECT_EQ(program.run("simulate a.csv 'b, c.csv' --html r.html" + options).status, 0);
  EXPECT_NE(readFile(program.folder / "r.html").find("<h2>b, c.csv</h2>"), std::string::npos);
}

TEST(Simulate, pageSizesAreSweptInOneRun) {
  const Program program;
  const std::string scene =
      std::string("simulate ") + kSmall + " --block 16 --frames 2 --sizes 64 --policies lru,lfu";
  auto expected = nlohmann::json::array();
  for (const std::string page : {"16x16x4", "8x8x8"}) {
    const auto alone = program.json(scene + " --page " + page);
    for (auto row : alone["rows"]) {
      row["page"] = page;
      expected.push_back(row);
    }
  }
  ASSERT_EQ(expected.size(), 4U);
  EXPECT_NE(expected[0]["bytes_moved"], expected[2]["bytes_moved"]);
  EXPECT_EQ(program.json(scene + " --page 16x16x4,8x8x8")["rows"], expected);
  EXPECT_EQ(program.json(scene + " --page 16x16x4 --page 8x8x8")["rows"], expected);
}

TEST(Simulate, printsTheTableOnStandardOutputAsCsv) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << skewedCsv(300);
  const CommandResult result = program.run("simulate t.csv --sizes 2K,10M --policies lru --csv -");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.output.rfind("policy,pages,requests,", 0), 0U) << result.output;
  EXPECT_NE(result.output.find("\nlru,2048,300,"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("\nlru,10485760,300,"), std::string::npos) << result.output;
  EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 3);
  EXPECT_FALSE(std::filesystem::exists(program.folder / "-"));
}

// Page requests have the same name in the table and in the summary above it.
TEST(Simulate, callsPageRequestsSoEverywhere) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << "1,7,8192\n2,8,4096\n3,7,8192\n";
  const std::string table = program.run("simulate t.csv --sizes 4 --policies lru").output;
  EXPECT_NE(table.find("  Chunk requests: 3\n  Page requests: 5\n"), std::string::npos) << table;
  EXPECT_NE(table.find(" miss ratio page requests "), std::string::npos) << table;
  EXPECT_NE(table.find("     0.6000             5 "), std::string::npos) << table;
  const auto row = program.json("simulate t.csv --sizes 4 --policies lru")["rows"][0];
  EXPECT_EQ(row["requests"], 5);
  EXPECT_DOUBLE_EQ(row["miss_ratio"].get<double>(), 0.6);
}

TEST(Simulate, compressedTracesGiveTheNumbersOfPlainOnes) {
  const Program program;
  std::ofstream(program.folder / "t.csv") << skewedCsv(3000);
  const std::string options = " --sizes 64 --policies lru,arc";
  const auto rows = program.json("simulate t.csv" + options)["rows"];
  const std::string plain = (program.folder / "t.csv").string();
  ASSERT_EQ(runCommand("gzip -c " + plain + " > " + (program.folder / "u.csv").string()).status, 0);
  EXPECT_EQ(program.json("simulate u.csv" + options)["rows"], rows);
  EXPECT_EQ(program.json("simulate u.csv --format csv" + options)["rows"], rows);
}

}  // namespace
}  // namespace sluice
