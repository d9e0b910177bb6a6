// Options that change nothing: a warning each, unless a saved view or a printed look gives them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;
using testing::Not;

class IdleOptions : public testing::Test {
 protected:
  // All that the run prints on either stream.
  std::string said(const std::string& more, const std::string& volume = kSmall) const {
    const CommandResult result =
        program_.run("render " + volume + " -o a.png --force --device cpu --size 32 " + more);
    EXPECT_EQ(result.status, 0) << more << ": " << result.output;
    return result.output;
  }
  std::string picture() const { return readFile(program_.folder / "a.png"); }

  const Program program_;
};

// An option, what makes it idle, and what makes it count.
struct Case {
  std::string option, idle, counts;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"--attenuation 3", "--mode mip", "--mode attenuated-mip"},
      {"--fov 50", "", "--projection perspective"},
      {"--combine blend", "", "--threshold 40 --over synth:cube,dims=48x40x36"},
      {"--merge first-fit", "--algorithm trimmed", "--algorithm merged"},
      {"--rate 5", "", ""},
      {"--difference 0.5", "--culling toc --threshold 40", ""},
      {"--directions 2", "", "--culling opof --threshold 40"},
      {"--opacity-threshold 0.5", "--mode mip", "--threshold 40"},
      {"--modulate", "--mode mip", "--threshold 40"},
      {"--modulate --full-gradient 0.5", "--mode minip", "--threshold 40"},
      {"--shade", "--mode mip", "--threshold 40"},
      {"--step 3", "--mode mip", "--mode average"},
      {"--seed 3", "", "--policy random"},
      {"--quality high", "--mode mip", "--threshold 40"},
      {"--quality high", "--iso 100", "--threshold 40"},
      {"--quality normal", "--step 3", "--step 2"},
      {"--range 20,90", "--labels", "--threshold 40"},
      {"--map hot", "--labels-table table.txt", "--labels"},
      {"--map hot", "--label all=red", "--label 1=red"},
      {"--map hot", "--look 0:red", "--look 0:,10:90"},
      {"--map hot", "--look 0:labels", "--labels"},
      {"--range 20,90", "--look 0:red,10:90", "--look 0:red"},
      {"--opacity 0.5", "--look 0:red,10:90,0.1", "--look 0:red,10:90"},
      {"--threshold 40", "--look 0:labels", "--look 0:red"},
      {"--ambient 0.5", "--no-shade", "--shade"},
      {"--opacity 0.5", "--mode mip", "--mode mip --threshold 40"}};
  return all;
}

TEST_F(IdleOptions, areAWarningEachAndChangeNoPicture) {
  std::ofstream table(program_.folder.path() / "table.txt");
  for (int label = 1; label < 256; ++label) table << label << " 255 0 0 1 1 1 \"one\"\n";
  table.close();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.option + " " + c.idle);
    const std::string name = c.option.substr(0, c.option.find(' '));
    EXPECT_THAT(said(c.idle), Not(HasSubstr("warning")));
    const std::string without = picture();
    const std::string line = said(c.option + " " + c.idle);
    EXPECT_THAT(line, HasSubstr("sluice: warning: "));
    EXPECT_THAT(line, HasSubstr(name));
    EXPECT_THAT(line, HasSubstr("changes nothing "));
    EXPECT_TRUE(picture() == without);
    EXPECT_THAT(said("-q " + c.option + " " + c.idle), Not(HasSubstr("changes nothing")));
    if (c.counts.empty()) continue;
    EXPECT_THAT(said(c.option + " " + c.counts), Not(HasSubstr("changes nothing")));
  }
}

// Whoever reads a report sees them whatever was printed.
TEST_F(IdleOptions, areInReportsAlsoOfQuietRuns) {
  for (const char* command : {"render -o a.png --force ", "plan "}) {
    SCOPED_TRACE(command);
    const auto report =
        program_.json(std::string(command) + kSmall + " -q --size 32 --fov 50 --threshold 300");
    EXPECT_THAT(report["warnings"],
                testing::Contains(HasSubstr("--fov changes nothing with an orthographic camera")));
  }
  const CommandResult plan = program_.run(std::string("plan --size 32 --threshold 300 ") + kSmall);
  EXPECT_THAT(plan.output, HasSubstr("warning: --threshold 300: nothing shows"));
}

TEST_F(IdleOptions, ofSamplingAreWarningsOfPlansTurnsAndBenches) {
  const std::string idle = "--quality changes nothing with a --step of more than 2 voxels";
  for (const char* command :
       {"plan ", "simulate --frames 1 --policies lru ", "bench render --frames 1 ",
        "bench algorithms --frames 1 ", "bench ranks --ranks 1 --frames 1 "}) {
    SCOPED_TRACE(command);
    const std::string line =
        command + std::string(kSmall) + " --size 32 --quality normal --threshold 40 --step ";
    EXPECT_THAT(program_.run(line + "3").output, HasSubstr(idle));
    EXPECT_THAT(program_.run(line + "2").output, Not(HasSubstr("changes nothing")));
  }
}

// Every bench that draws warns of them, and of nothing that counts. Options of the rows are told
// as such.
TEST_F(IdleOptions, areWarningsOfEveryBench) {
  struct BenchLine {
    const char* words;
    const char* own;  // an option that each row has for itself
  };
  const BenchLine benches[] = {{"render --frames 1", nullptr},
                               {"threshold --changes 2", nullptr},
                               {"algorithms --frames 1", "--algorithm trimmed"},
                               {"skipping --frames 1", "--partition boxes"},
                               {"occlusion --frames 1", "--occlusion cull"},
                               {"quality --frames 1", "--step 2"},
                               {"ranks --ranks 1 --frames 1", nullptr}};
  for (const BenchLine& bench : benches) {
    SCOPED_TRACE(bench.words);
    const std::string line =
        fmt::format("bench {} {} --size 32 --threshold 40 ", bench.words, kSmall);
    const auto said = [&](const std::string& more) {
      const CommandResult result = program_.run(line + more);
      EXPECT_EQ(result.status, 0) << more << ": " << result.output;
      return result.output;
    };
    EXPECT_THAT(said(""), Not(HasSubstr("changes nothing")));
    for (const char* idle : {"--attenuation 2", "--fov 50", "--combine blend"})
      EXPECT_THAT(said(idle), HasSubstr(std::string(idle).substr(0, std::string(idle).find(' ')) +
                                        " changes nothing"))
          << idle;
    // These two benches are lit.
    const bool is_lit = bench.words[0] == 's' || bench.words[0] == 'o';
    for (const std::string option : {"--light 3,4", "--ambient 0.5"}) {
      const std::string idle = option.substr(0, option.find(' ')) + " changes nothing";
      if (!is_lit) {
        EXPECT_THAT(said(option), HasSubstr(idle));
      }
      EXPECT_THAT(said("--shade " + option), Not(HasSubstr(idle)));
    }
    if (!is_lit) {
      EXPECT_THAT(said("--shadows"), HasSubstr("--shadows changes nothing"));
    }
    if (bench.own != nullptr) {
      EXPECT_THAT(said(bench.own), HasSubstr("changes nothing here: each row has its own"));
    }
  }
}

// The benches of series and of several channels, too.
TEST_F(IdleOptions, ofSamplingAreWarningsOfBenchesOfSeveralVolumes) {
  ASSERT_EQ(program_.run("synth mixing -o mix_%03d.nrrd --dims 16,16,16 --steps 2 -q").status, 0);
  const std::string series =
      "bench culling mix_%03d.nrrd --size 32 --quality normal --threshold 40 --no-thresholds "
      "--no-optimum --views 1 ";
  EXPECT_THAT(program_.run(series + "--step 3").output,
              HasSubstr("--quality changes nothing with a --step of more than 2 voxels"));
  EXPECT_THAT(program_.run(series + "--no-series").output,
              HasSubstr("--quality changes nothing with --no-series"));
  EXPECT_THAT(program_.run(series).output, Not(HasSubstr("changes nothing")));
}

TEST_F(IdleOptions, areWarningsOfBenchesOfQualityAndOfTheWindow) {
  const std::string of_bench =
      std::string("bench quality --frames 1 --size 24 --threshold 40 ") + kSmall;
  for (const char* option : {"--quality", "--step"})
    EXPECT_THAT(program_.run(of_bench + " " + option + (option[2] == 'q' ? " high" : " 2")).output,
                HasSubstr(std::string("warning: ") + option + " changes nothing here"));
  EXPECT_THAT(program_.run(of_bench + " --fov 50").output,
              HasSubstr("--fov changes nothing with an orthographic camera"));
  EXPECT_THAT(program_.run(of_bench).output, Not(HasSubstr("changes nothing")));
  const std::string of_window =
      std::string("bench view --device cpu --events 2 --size 24 --threshold 40 ") + kSmall;
  EXPECT_THAT(program_.run(of_window + " --quality high --step 3").output,
              HasSubstr("--quality changes nothing with a --step of more than 2 voxels"));
  EXPECT_THAT(program_.run(of_window + " --quality high --step 1").output,
              Not(HasSubstr("changes nothing")));
}

// Simulations have them in their report, as plans have.
TEST_F(IdleOptions, areInReportsOfSimulations) {
  const std::string line = std::string("simulate --frames 1 --policies lru -q --size 32 ") + kSmall;
  EXPECT_THAT(program_.json(line + " --fov 50 --threshold 300")["warnings"],
              testing::IsSupersetOf(
                  {testing::Matcher<std::string>(
                       HasSubstr("--fov changes nothing with an orthographic camera")),
                   testing::Matcher<std::string>(HasSubstr("--threshold 300: nothing shows"))}));
  EXPECT_THAT(program_.json(line + " --threshold 40")["warnings"], testing::IsEmpty());
}

// Below a voxel, a step takes places between the planes of voxels.
TEST_F(IdleOptions, smallStepsCountInModesOnPlanes) {
  for (const std::string mode : {"--mode mip", "--mode depth-mip"}) {
    said(mode + " --azimuth 20");
    const std::string without = picture();
    EXPECT_THAT(said(mode + " --azimuth 20 --step 0.25"), Not(HasSubstr("warning")));
    EXPECT_FALSE(picture() == without) << mode;
    EXPECT_THAT(said(mode + " --azimuth 20 --step 1"), HasSubstr("--step changes nothing"));
    EXPECT_TRUE(picture() == without) << mode;
  }
}

TEST_F(IdleOptions, aboutLevelsAreWarningsIfOneLevelIsDrawn) {
  const std::string why = " changes nothing in a picture from level 0 alone";
  for (const std::string option : {"--pixel-error 3", "--max-bytes 1M", "--keep-thin"}) {
    const std::string name = option.substr(0, option.find(' '));
    EXPECT_THAT(said(option), HasSubstr(name + why));
    EXPECT_THAT(program_.run(std::string("plan ") + kSmall + " --size 32 " + option).output,
                HasSubstr(name + why));
    EXPECT_THAT(said(option, "synth:shells,dims=160x140x120,levels=4"),
                Not(HasSubstr("changes nothing")));
  }
  EXPECT_THAT(program_.run(std::string("plan ") + kSmall + " --size 32 --time-limit 9").output,
              HasSubstr("--time-limit changes nothing in the plan"));
  const CommandResult bench =
      program_.run(std::string("bench render ") + kSmall + " --frames 1 --time-limit 9");
  EXPECT_EQ(bench.status, 2);
  EXPECT_THAT(bench.output, HasSubstr("has no option --time-limit"));
  // Without a level for labels, they are drawn from level 0.
  EXPECT_THAT(said("--keep-thin --labels --levels always", "synth:parts,dims=48x40x36"),
              testing::AnyOf(HasSubstr("--keep-thin" + why), Not(HasSubstr("warning"))));
}

TEST_F(IdleOptions, areWarningsOfPlansToo) {
  const auto planned = [&](const std::string& more) {
    return program_.run(std::string("plan ") + kSmall + " --threshold 40 " + more).output;
  };
  EXPECT_THAT(planned("--fov 50"), HasSubstr("--fov changes nothing with an orthographic camera"));
  EXPECT_THAT(planned("--shadows --light 1,2 --projection perspective --fov 50"),
              Not(HasSubstr("changes nothing")));
}

TEST_F(IdleOptions, areWarningsOfSimulationsToo) {
  const auto simulated = [&](const std::string& more) {
    return program_
        .run(std::string("simulate ") + kSmall + " --frames 2 --sizes 64 --policies lru " + more)
        .output;
  };
  const std::string all = simulated("--fov 50 --keep-thin --seed 3 --page 8x8x8,16x16x16");
  EXPECT_THAT(all, HasSubstr("--fov changes nothing with an orthographic camera"));
  EXPECT_THAT(all, HasSubstr("--keep-thin changes nothing in a picture from level 0 alone"));
  EXPECT_EQ(all.find("--fov changes"), all.rfind("--fov changes"));
  EXPECT_THAT(all, Not(HasSubstr("--seed")));
  EXPECT_THAT(simulated("-q --fov 50"), Not(HasSubstr("changes nothing")));
  EXPECT_THAT(simulated("--fov 50 --projection perspective"), Not(HasSubstr("warning")));
}

TEST_F(IdleOptions, ofASavedViewAreNoWarning) {
  std::ofstream(program_.folder / "view.json") << R"({"sluice": "view",
      "camera": {"fov": 50}, "step": 3, "key_light": [9, 9], "quality": "high",
      "look": {"mode": "mip", "attenuation": 3, "opacity": 0.5, "light": "on",
               "full_gradient": 0.5, "combine": "blend"}})";
  EXPECT_THAT(said("--state view.json"), Not(HasSubstr("warning")));
  const std::string view = picture();
  std::ofstream(program_.folder / "plain.json") << R"({"sluice": "view", "look": {"mode": "mip"}})";
  said("--state plain.json");
  EXPECT_TRUE(picture() == view);
  // The user's own options are another matter, and the file's count in the user's mode.
  EXPECT_THAT(said("--state view.json --step 2"), HasSubstr("--step changes nothing in this"));
  EXPECT_THAT(said("--state view.json --mode attenuated-mip"), HasSubstr("--attenuation 3"));
}

TEST_F(IdleOptions, areNotInALookThatIsPrinted) {
  for (const std::string mode : {"mip", "attenuated-mip", "average"}) {
    const std::string asked = "--mode " + mode + " --modulate --shade";
    const std::string look =
        program_.json(std::string("render ") + kSmall + " -o a.png --force --size 32 " +
                      asked)["look"]["options"];
    EXPECT_THAT(look, Not(HasSubstr("--modulate")));
    EXPECT_THAT(look, Not(HasSubstr("--shade")));
    EXPECT_THAT(said("--mode " + mode + " " + look), Not(HasSubstr("warning")));
  }
  for (const std::string more : {"", "--threshold 40 --modulate", "--iso 100", "--no-shade"}) {
    const std::string look = program_.json(
        std::string("render ") + kSmall + " -o a.png --force --size 32 " + more)["look"]["options"];
    EXPECT_THAT(said(look), Not(HasSubstr("warning"))) << look;
  }
}

}  // namespace
}  // namespace sluice
