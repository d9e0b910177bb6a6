// Pictures and series by ranks that mpirun has started: the same as of one process, one voice, and
// one end for all when something goes wrong.
#include "tests/parallel/ranks_program.h"

#include <csignal>
#include <fstream>

#include "src/parallel/communication/mpi_ranks.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPicture = "synth:shells,dims=60x52x48 --block 8 --size 90x70 --memory 300M";

Launch launchWith(const std::map<std::string, std::string>& variables) {
  return launchOf([&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}

TEST(LaunchOf, knowsWhoStartedIt) {
  EXPECT_EQ(launchWith({}).ranks, 1);
  const Launch open = launchWith({{"OMPI_COMM_WORLD_RANK", "3"}, {"OMPI_COMM_WORLD_SIZE", "8"}});
  EXPECT_EQ(open.rank, 3);
  EXPECT_EQ(open.ranks, 8);
  EXPECT_TRUE(open.kind == MpiKind::kOpenMpi);
  const Launch mpich = launchWith({{"PMI_RANK", "0"}, {"PMI_SIZE", "2"}});
  EXPECT_TRUE(mpich.ranks == 2 && mpich.kind == MpiKind::kMpich);
  const Launch pmix = launchWith({{"PMIX_RANK", "1"}, {"SLURM_STEP_NUM_TASKS", "4"}});
  EXPECT_TRUE(pmix.ranks == 4 && pmix.kind == MpiKind::kOpenMpi);
  const Launch none = launchWith({{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "4"}});
  EXPECT_TRUE(none.ranks == 4 && !none.kind);
  // A batch script's own step, and malformed values.
  EXPECT_EQ(launchWith({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}}).ranks, 1);
  EXPECT_EQ(launchWith({{"PMI_RANK", "x"}, {"PMI_SIZE", "2"}}).ranks, 1);
  EXPECT_EQ(launchWith({{"PMI_RANK", "2"}, {"PMI_SIZE", "2"}}).ranks, 1);
}

// Without the module the first rank prints one line, and the others nothing.
TEST(RanksWithoutMpi, saySoInOneLine) {
  const Program program;
  std::filesystem::copy_file(SLUICE_PROGRAM, program.folder / "sluice");
  const auto asRank = [&](int rank) {
    return runCommand(
        fmt::format("cd {} && OMPI_COMM_WORLD_SIZE=4 OMPI_COMM_WORLD_RANK={} ./sluice "
                    "render synth:shells -o a.png --index-dir .",
                    shellQuoted(program.folder.path().string()), rank));
  };
  const CommandResult first = asRank(0);
  EXPECT_EQ(first.status, 1);
  EXPECT_EQ(occurrences(first.output, "\n"), 1) << first.output;
  EXPECT_THAT(first.output, HasSubstr("started as 4 ranks of Open MPI, which do not meet"));
  EXPECT_THAT(first.output, HasSubstr("libopenmpi-dev"));
  const CommandResult other = asRank(1);
  EXPECT_EQ(other.status, 1);
  EXPECT_EQ(other.output, "");
}

TEST(BenchRanks, measuresRanksOfThreads) {
  const Program program;
  const json report = program.json(
      "bench ranks synth:shells,dims=48x40x36 --threshold 40 --ranks 1,3 --frames 2 --size 64");
  ASSERT_EQ(report["rows"].size(), 2U);
  EXPECT_EQ(report["rows"][1]["ranks"], 3);
  EXPECT_EQ(report["rows"][0]["speedup"], 1);
  for (const json& row : report["rows"]) EXPECT_GT(row["frame_seconds"]["median"].get<double>(), 0);
  EXPECT_GT(report["rows"][1]["sent_bytes"], 0);
  EXPECT_EQ(program.run("bench ranks synth:shells --ranks 1,0").status, 2);
}

TEST(BenchCulling, dealsTheVisibleBlocksToRanks) {
  const Program program;
  ASSERT_EQ(program.run("synth mixing -o mix_%03d.nrrd --dims 64,64,64 --steps 3 -q").status, 0);
  const json report = program.json(
      "bench culling mix_%03d.nrrd --threshold 100 --opacity 1 --block 8 --views 1 --size 64 "
      "--no-optimum --no-thresholds --no-series");
  ASSERT_EQ(report["ranks"].size(), 5U);
  int64_t visible = 0, compared = 0, coherent = 0;
  for (const json& row : report["rows"]) {
    visible += row["visible"]["toc"].get<int64_t>();
    EXPECT_LE(row["visible"]["linear_opof"], row["blocks_nonempty"]);
    EXPECT_GE(row["visible"]["pof"], row["visible"]["linear_opof"]) << "Gao 2004, Figure 11";
    if (row["time"] == 0) continue;
    compared += row["compared_blocks"].get<int64_t>();
    coherent += row["coherent_blocks"].get<int64_t>();
  }
  EXPECT_DOUBLE_EQ(report["coherent_share"].get<double>(),
                   static_cast<double>(coherent) / static_cast<double>(compared));
  // A leaf for each block and the nodes above them, a bit for each change of steps.
  EXPECT_GT(report["tree"]["nodes"].get<int64_t>(), 7 * 7 * 7);
  EXPECT_GT(report["tree"]["bytes"].get<int64_t>(), 0);
  EXPECT_GT(report["tree"]["seconds"].get<double>(), 0);
  for (const json& row : report["ranks"]) {
    int64_t sum = 0;
    for (const json& blocks : row["blocks"]) sum += blocks.get<int64_t>();
    EXPECT_EQ(sum, visible);
    EXPECT_EQ(row["blocks"].size(), row["ranks"].get<size_t>());
    EXPECT_LE(row["most_to_mean"].get<double>(), 1.25) << row["ranks"];
  }
}

class RanksProgram : public RanksTest {
 protected:
  CommandResult onRanks(int ranks, const std::string& arguments) const {
    return runCommand(inFolder() + GetParam().start(ranks) + " " + arguments);
  }
  std::string inFolder() const {
    return "cd " + shellQuoted(program_.folder.path().string()) +
           "; export XDG_CACHE_HOME=\"$PWD/cache\"; ";
  }
  void makeSeries(int steps) const {
    ASSERT_EQ(
        program_
            .run(fmt::format("synth mixing -o mix_%03d.nrrd --dims 48,48,48 --steps {} -q", steps))
            .status,
        0);
  }
  static std::string series(const std::string& more) {
    return "render mix_%03d.nrrd --threshold 100 --opacity 1 --block 8 --no-shade --size 48 " +
           more;
  }
  const Program program_;
};

TEST_P(RanksProgram, drawThePictureOfOneProcess) {
  const std::string modes[] = {"", "--no-shade --projection perspective", "--mode mip",
                               "--mode average --projection perspective"};
  for (const std::string& mode : modes) {
    const json one = program_.json(fmt::format("render {} {} -o one.png", kPicture, mode));
    for (const int ranks : mode.empty() ? std::vector{2, 4, 7} : std::vector{3}) {
      SCOPED_TRACE(fmt::format("{} ranks, {}", ranks, mode));
      const CommandResult run =
          onRanks(ranks, fmt::format("render {} {} -o many.png --json -q", kPicture, mode));
      ASSERT_EQ(run.status, 0) << run.output;
      EXPECT_LE(pictureDifference(program_.folder / "one.png", program_.folder / "many.png"), 1);
      const json many = json::parse(run.output);
      ASSERT_EQ(many["ranks"].size(), static_cast<size_t>(ranks));
      EXPECT_EQ(many["frames"][0]["blocks"]["grey"], one["frames"][0]["blocks"]["grey"]);
      EXPECT_EQ(many["frames"][0]["samples_object"], one["frames"][0]["samples_object"]);
      EXPECT_FALSE(one.contains("ranks"));
    }
  }
}

TEST_P(RanksProgram, drawTheCutThroughLevelsOfOneProcess) {
  constexpr const char* kLook =
      "--size 36x30 --threshold 60 --no-shade --memory 300M "
      "--background 000000";  // colours of nearly nothing are rounding
  constexpr const char* kMany = "synth:shells,dims=100x94x88,levels=4 --block 8";
  // Of so few blocks that some ranks have none of a coarse level.
  constexpr const char* kFew = "synth:shells,dims=90x80x70,levels=3";
  const std::pair<const char*, const char*> cases[] = {
      {kMany, ""},
      {kMany, "--level 3"},
      {kMany, "--projection perspective --zoom 3 --pixel-error 2"},
      {kMany, "--pixel-error 0.3 --max-bytes 300K"},
      {kMany, "--iso 90 --projection perspective --zoom 3 --pixel-error 2"},
      {kMany, "--iso 70:0.4,120 --level 1"},
      {kMany, "--iso 70:0.4,120 --projection perspective --zoom 3 --pixel-error 2"},
      {kMany, "--iso 90 --level 2"},
      {kFew, ""},
      {kFew, "--projection perspective --zoom 0.5 --pixel-error 2"}};
  for (const auto& [volume, cut] : cases) {
    const std::string picture = fmt::format("render {} {} {}", volume, kLook, cut);
    json one = program_.json(picture + " -o one.png");
    one["cut"].erase("spread");  // a rank knows its own blocks alone
    for (const int ranks : {2, 5}) {
      SCOPED_TRACE(fmt::format("{} ranks, {}", ranks, picture));
      const CommandResult run = onRanks(ranks, picture + " -o many.png --json -q");
      ASSERT_EQ(run.status, 0) << run.output;
      EXPECT_LE(pictureDifference(program_.folder / "one.png", program_.folder / "many.png"), 1);
      const json many = json::parse(run.output);
      EXPECT_GT(many["cut"]["coarse_share"], 0.3);
      EXPECT_EQ(many["cut"], one["cut"]);
    }
  }
}

TEST_P(RanksProgram, keepToTheirOwnBudgets) {
  for (const int memory_mib : {24, 200}) {
    const CommandResult run =
        onRanks(3, fmt::format("render synth:phantom,dims=160x160x160 --size 300 --memory {}M "
                               "--block 32 --page 16x16x16 --pages 256 -o a.png --json -q",
                               memory_mib));
    ASSERT_EQ(run.status, 0) << run.output;
    for (const json& rank : json::parse(run.output)["ranks"]) {
      const uint64_t budget = static_cast<uint64_t>(memory_mib) << 20;
      EXPECT_EQ(rank["memory_bytes"], budget);
      uint64_t held = rank["received_bytes"].get<uint64_t>();
      for (const char* level : {"volume_buffer", "texture_buffer"}) {
        const json& counters = rank["levels"][level];
        EXPECT_LE(counters["peak_bytes"].get<uint64_t>(), counters["budget_bytes"].get<uint64_t>());
        held += counters["peak_bytes"].get<uint64_t>();
      }
      EXPECT_LE(rank["part_bytes"].get<uint64_t>(), rank["part_memory_bytes"].get<uint64_t>() / 2);
      EXPECT_LE(held, budget);
      EXPECT_LE(rank["peak_anonymous_bytes"].get<uint64_t>(), budget + (uint64_t{64} << 20));
    }
  }
  const CommandResult small =
      onRanks(2,
              "render synth:phantom,dims=160x160x160 --size 3000 --memory 24M --block 32 --page "
              "16x16x16 --pages 256 -o b.png");
  EXPECT_EQ(small.status, 1);
  EXPECT_EQ(occurrences(small.output, "sluice: "), 1) << small.output;
  EXPECT_THAT(small.output, HasSubstr("give more --memory or a smaller --size"));
  EXPECT_FALSE(program_.exists("b.png"));
}

// A view from close by sees few groups of blocks, which may all be one rank's.
TEST_P(RanksProgram, drawWhatOneOfThemSeesAlone) {
  const std::string command =
      "render synth:cube,dims=64x64x64 --opacity 0.001 --zoom 4 --block 32 --size 101x110 --json "
      "-q "
      "-o ";
  ASSERT_EQ(program_.run(command + "alone.png").status, 0);
  for (const int ranks : {4, 8}) {
    const CommandResult run = onRanks(ranks, command + "together.png --force --memory 2G");
    ASSERT_EQ(run.status, 0) << ranks << run.output;
    EXPECT_LE(pictureDifference(program_.folder / "alone.png", program_.folder / "together.png"), 1)
        << ranks;
    for (const json& rank : json::parse(run.output)["ranks"])
      EXPECT_LE(rank["part_bytes"].get<uint64_t>(), rank["part_memory_bytes"].get<uint64_t>() / 2);
  }
}

// The look and the fit come from a coarse level then.
TEST_P(RanksProgram, openAStoreWithoutAnIndexAsOneProcessDoes) {
  const CommandResult packed =
      program_.run("pack synth:phantom,dims=160x150x140 -o soon.zarr --chunk 32 --levels 3 -q");
  ASSERT_EQ(packed.status, 0) << packed.output;
  const std::string command = "render soon.zarr --size 60x50 -o ";
  const auto forget = [&] { std::filesystem::remove_all(program_.folder / "cache"); };
  forget();
  ASSERT_EQ(program_.run(command + "alone.png").status, 0);
  forget();
  const CommandResult run = onRanks(3, command + "together.png");
  ASSERT_EQ(run.status, 0) << run.output;
  EXPECT_EQ(occurrences(run.output, "level 0 has no index yet"), 1) << run.output;
  EXPECT_LE(pictureDifference(program_.folder / "alone.png", program_.folder / "together.png"), 1);
}

TEST_P(RanksProgram, speakWithOneVoice) {
  const CommandResult run = onRanks(3, fmt::format("render {} -o a.png", kPicture));
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(occurrences(run.output, "look: "), 1) << run.output;
  EXPECT_THAT(run.output, HasSubstr("3 ranks"));
  const CommandResult usage = onRanks(3, "render a.raw -o a.png --size none");
  EXPECT_NE(usage.status, 0);
  EXPECT_EQ(occurrences(usage.output, "sluice: "), 1) << usage.output;
  const CommandResult other = onRanks(3, "info synth:shells");
  EXPECT_NE(other.status, 0);
  EXPECT_EQ(occurrences(other.output, "sluice: started as 3 ranks; render"), 1) << other.output;
  const CommandResult missing = onRanks(3, "render nothing.nrrd -o a.png");
  EXPECT_NE(missing.status, 0);
  EXPECT_EQ(occurrences(missing.output, "sluice: "), 1) << missing.output;
  EXPECT_THAT(missing.output, HasSubstr("nothing.nrrd: cannot be opened"));
}

TEST_P(RanksProgram, drawSeriesWithCulling) {
  makeSeries(5);
  ASSERT_EQ(program_.run(series("--time 0:4 --culling toc -o one_%03d.png -q")).status, 0);
  for (const int ranks : {2, 5}) {
    const CommandResult run =
        onRanks(ranks, series("--time 0:4 --culling toc -o many_%03d.png --force --json -q"));
    ASSERT_EQ(run.status, 0) << run.output;
    const json report = json::parse(run.output);
    const json one = program_.json(series("--time 0:4 --culling toc -o again_%03d.png --force"));
    for (size_t step = 0; step < 5; ++step) {
      EXPECT_LE(pictureDifference(program_.folder / fmt::format("one_{:03}.png", step),
                                  program_.folder / fmt::format("many_{:03}.png", step)),
                1)
          << ranks << " step " << step;
      EXPECT_EQ(report["frames"][step]["culling"]["visible"],
                one["frames"][step]["culling"]["visible"]);
      EXPECT_EQ(report["frames"][step]["blocks"]["grey"], one["frames"][step]["blocks"]["grey"]);
    }
  }
}

TEST_P(RanksProgram, endTogetherAtAStepThatIsCut) {
  makeSeries(5);
  const std::string whole = readFile(program_.folder / "mix_003.nrrd");
  const std::string command = series("--time 0:4 -o a_%03d.png --continue");
  writeFile(program_.folder / "mix_003.nrrd", std::string_view(whole).substr(0, whole.size() / 2));
  const CommandResult cut = onRanks(3, command);
  EXPECT_NE(cut.status, 0);
  EXPECT_EQ(occurrences(cut.output, "sluice: "), 1) << cut.output;
  EXPECT_THAT(cut.output, HasSubstr("mix_003.nrrd"));
  // A missing file, and a file of another size.
  std::filesystem::rename(program_.folder / "mix_003.nrrd", program_.folder / "away");
  const CommandResult missing = onRanks(3, command);
  EXPECT_NE(missing.status, 0);
  EXPECT_EQ(occurrences(missing.output, "sluice: "), 1) << missing.output;
  EXPECT_THAT(missing.output, HasSubstr("mix_003.nrrd"));
  EXPECT_EQ(program_.run("synth mixing -o mix_003.nrrd --dims 40,48,48 -q").status, 0);
  const CommandResult other = onRanks(3, command);
  EXPECT_NE(other.status, 0);
  EXPECT_EQ(occurrences(other.output, "sluice: "), 1) << other.output;
  EXPECT_THAT(other.output, HasSubstr("mix_003.nrrd"));
  writeFile(program_.folder / "mix_003.nrrd", whole);
  const CommandResult again = onRanks(3, command);
  EXPECT_EQ(again.status, 0) << again.output;
  ASSERT_EQ(program_.run(series("--time 0:4 -o one_%03d.png -q")).status, 0);
  for (int step = 0; step < 5; ++step)
    EXPECT_LE(pictureDifference(program_.folder / fmt::format("one_{:03}.png", step),
                                program_.folder / fmt::format("a_{:03}.png", step)),
              1)
        << step;
}

TEST_P(RanksProgram, shareOutEveryBlockOfAlgorithmsThatLoadThemAll) {
  makeSeries(2);
  for (const char* algorithm : {"conventional", "clipped"})
    for (const char* mode : {"composite", "mip", "attenuated-mip", "average"}) {
      const std::string command = series(
          fmt::format("--time 0:1 --algorithm {} --mode {} --force --json", algorithm, mode));
      const json one = program_.json(command + " -o one_%03d.png");
      for (const int ranks : {2, 3}) {
        SCOPED_TRACE(fmt::format("{} {} on {} ranks", algorithm, mode, ranks));
        const CommandResult run = onRanks(ranks, command + " -o many_%03d.png -q");
        ASSERT_EQ(run.status, 0) << run.output;
        const json many = json::parse(run.output);
        for (size_t step = 0; step < 2; ++step) {
          EXPECT_LE(pictureDifference(program_.folder / fmt::format("one_{:03}.png", step),
                                      program_.folder / fmt::format("many_{:03}.png", step)),
                    1);
          // Every block once. The pass over a later step's values leaves some of its blocks in
          // memory, at each rank others than in one process.
          const auto all = many["frames"][step]["decoded_bytes"].get<double>();
          const auto whole = one["frames"][0]["decoded_bytes"].get<double>();
          EXPECT_LE(all, whole);
          EXPECT_GE(all, step == 0 ? whole : 0.9 * whole);
        }
      }
    }
}

// A second refusal followed the first, or the same number was refused.
TEST_P(RanksProgram, namesAMemoryThatWorksAtOnce) {
  const std::string command = "render synth:shells,dims=96x96x96 --block 16 -o a.png --force -q";
  for (const char* more : {" --size 100", " --size 600"}) {
    const CommandResult refused = onRanks(2, command + more + " --memory 1M");
    EXPECT_EQ(refused.status, 1);
    const size_t at = refused.output.find(", and ");
    ASSERT_NE(at, std::string::npos) << refused.output;
    const uint64_t named = std::stoull(refused.output.substr(at + 6));
    const CommandResult enough = onRanks(2, fmt::format("{}{} --memory {}", command, more, named));
    EXPECT_EQ(enough.status, 0) << refused.output << enough.output;
    const size_t least = refused.output.find("needs at least ");
    ASSERT_NE(least, std::string::npos) << refused.output;
    const uint64_t too_little = std::stoull(refused.output.substr(least + 15)) - 1;
    EXPECT_EQ(onRanks(2, fmt::format("{}{} --memory {}", command, more, too_little)).status, 1);
  }
}

// When a rank is killed while pictures are drawn, the launcher ends the run and names it.
TEST_P(RanksProgram, areEndedWhenOneIsKilled) {
  const std::string command =
      "render synth:shells,dims=96x96x96 --block 16 --size 300 --frames 60 -o turn_%03d.png "
      "--continue -q";
  const CommandResult killed = runCommand(
      inFolder() + GetParam().start(3) + " " + command +
      " & run=$!; for i in $(seq 600); do [ -e turn_004.png ] && break; sleep 0.05; done; "
      // Picks a process that runs the program in this folder.
      "for p in /proc/[0-9]*; do "
      "  if [ $p/cwd -ef . ] && [ $p/exe -ef " SLUICE_PROGRAM
      " ]; then one=$p; fi; "
      "done; kill -9 ${one#/proc/}; wait $run; echo ended with $?");
  EXPECT_THAT(killed.output, Not(HasSubstr("ended with 0"))) << killed.output;
  EXPECT_THAT(killed.output, Not(HasSubstr("ended with 124"))) << "hangs " << killed.output;
  EXPECT_EQ(occurrences(killed.output, "sluice: "), 0) << killed.output;
  int there = 0;
  for (int i = 0; i < 60; ++i) {
    const auto picture = program_.folder / fmt::format("turn_{:03}.png", i);
    if (!std::filesystem::exists(picture)) continue;
    EXPECT_EQ(readPng(picture).width, 300);
    ++there;
  }
  EXPECT_GE(there, 5);
  EXPECT_LT(there, 60);
  const CommandResult again = onRanks(3, command);
  EXPECT_EQ(again.status, 0) << again.output;
  for (const auto& file : std::filesystem::directory_iterator(program_.folder.path()))
    EXPECT_THAT(file.path().filename().string(), Not(HasSubstr(".tmp")));
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(program_.exists(fmt::format("turn_{:03}.png", i))) << i;
}

INSTANTIATE_TEST_SUITE_P(By, RanksProgram, testing::Values(kOpenMpiLauncher, kMpichLauncher),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace sluice
