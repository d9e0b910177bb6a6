// Series with culling, as a user draws them: prepare, render over time steps, bench, and failures
// on the way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kLook = "--threshold 100 --opacity 1 --block 8 --no-shade";
constexpr const char* kPicture = "--size 48 --azimuth 30 --elevation 20 --view plain";

class CullingCommand : public testing::Test {
 protected:
  CullingCommand() {
    EXPECT_EQ(program_.run("synth mixing -o mix_%03d.nrrd --dims 48,48,48 --steps 6 -q").status, 0);
  }
  CommandResult render(const std::string& more) const {
    return program_.run(std::string("render mix_%03d.nrrd ") + kLook + " " + kPicture + " " + more);
  }
  json renderJson(const std::string& more) const {
    return program_.json(std::string("render mix_%03d.nrrd ") + kLook + " " + kPicture + " " +
                         more);
  }
  const Program program_;
};

TEST_F(CullingCommand, prepareMakesFunctionsOnce) {
  const auto prepare = [](int threshold, double opacity) {
    return fmt::format("prepare mix_%03d.nrrd --threshold {} --opacity {} --block 8 --no-shade",
                       threshold, opacity);
  };
  const std::string command = prepare(100, 0.8);
  const json made = program_.json(command);
  EXPECT_EQ(made["steps"], 6);
  EXPECT_GT(made["blocks"], 300);
  EXPECT_GT(made["functions"], 1);
  EXPECT_GT(made["bytes"], 0);
  EXPECT_EQ(made["state"], "built");
  for (const char* part : {"functions", "fusion", "tree"})
    EXPECT_GE(made["seconds"][part].get<double>(), 0);
  EXPECT_GT(made["coherent_share"].get<double>(), 0.2);
  const json read = program_.json(command);
  EXPECT_EQ(read["state"], "read");
  for (const char* same : {"functions", "bytes", "coherent_share", "spans", "path"})
    EXPECT_EQ(read[same], made[same]) << same;
  // Opacity edits take no new pass, as far as the new opacity is nowhere much less.
  const json edited = program_.json(prepare(100, 0.6));
  EXPECT_EQ(edited["state"], "read");
  EXPECT_LT(edited["exponent"].get<double>(), 1);
  EXPECT_GT(edited["exponent"].get<double>(), 0.2);
  const json other = program_.json(prepare(60, 0.01));
  EXPECT_EQ(other["state"], "built");
  EXPECT_EQ(program_.json(command)["state"], "read") << "both are kept";
  // A step that changes makes them anew.
  EXPECT_EQ(program_.run("synth mixing -o mix_003.nrrd --dims 48,48,48 --seed 9 -q --force").status,
            0);
  EXPECT_EQ(program_.json(command)["state"], "built");
}

// The plan of a step has the blocks that its picture reads.
TEST_F(CullingCommand, functionsThatCannotBeKeptAreAnError) {
  std::ofstream(program_.folder / "plain") << "no folder";
  const std::string prepare = std::string("prepare -q mix_%03d.nrrd ") + kLook;
  const CommandResult lost = program_.run(prepare + " --index-dir plain/x");
  EXPECT_EQ(lost.status, 1);
  EXPECT_TRUE(isOneLine(lost.output)) << lost.output;
  EXPECT_THAT(lost.output, HasSubstr("computed, but not kept: "));
  EXPECT_THAT(lost.output, HasSubstr("plain/x"));
}

TEST_F(CullingCommand, isPlannedOncePrepared) {
  const auto plan = [](const std::string& more) {
    return std::string("plan mix_%03d.nrrd ") + kLook + " " + kPicture + " --time 3 " + more;
  };
  const CommandResult early = program_.run(plan("--culling toc"));
  EXPECT_EQ(early.status, 1);
  EXPECT_THAT(early.output, HasSubstr("mix_%03d.nrrd: the series is not prepared for this look"));
  EXPECT_EQ(program_.run(std::string("prepare mix_%03d.nrrd -q ") + kLook).status, 0);
  const json none = program_.json(plan("")), toc = program_.json(plan("--culling toc"));
  const json drawn = renderJson("--time 3:3 --culling toc -o a.png");
  const json& of_picture = drawn["frames"][0]["culling"];
  EXPECT_EQ(toc["culling"]["visible"], of_picture["visible"]);
  EXPECT_EQ(toc["culling"]["blocks_nonempty"], of_picture["blocks_nonempty"]);
  EXPECT_EQ(toc["read"]["blocks"], of_picture["visible"]);
  EXPECT_LT(toc["read"]["blocks"], none["read"]["blocks"]);
  EXPECT_GT(toc["memory"]["peak_bytes"].get<int64_t>(), 0);
  EXPECT_THAT(program_.run(plan("--culling toc")).output,
              HasSubstr("that are not empty can be seen"));
  for (const char* refused :
       {"--culling auto", "--culling toc --mode mip", "--culling toc --pixel-error 2"})
    EXPECT_EQ(program_.run(plan(refused)).status, 2) << refused;
}

TEST_F(CullingCommand, tornFunctionsAreMadeAnew) {
  const std::string command = std::string("prepare mix_%03d.nrrd ") + kLook;
  const json made = program_.json(command);
  std::filesystem::resize_file(made["path"].get<std::string>(), 1000);
  const json again = program_.json(command);
  EXPECT_EQ(again["state"], "built");
  EXPECT_EQ(again["bytes"], made["bytes"]);
}

TEST_F(CullingCommand, stepsLookAsWithoutCulling) {
  const json plain = renderJson("--time 0:5 -o none_%03d.png");
  EXPECT_EQ(plain["frames"].size(), 6U);
  int64_t last = 1 << 30;
  for (const char* way : {"pof", "opof", "toc"}) {
    const json culled = renderJson(fmt::format("--time 0:5 --culling {0} -o {0}_%03d.png", way));
    int64_t visible = 0, nonempty = 0;
    for (const json& frame : culled["frames"]) {
      visible += frame["culling"]["visible"].get<int64_t>();
      nonempty += frame["culling"]["blocks_nonempty"].get<int64_t>();
    }
    EXPECT_LT(visible, way == std::string("pof") ? nonempty + 1 : nonempty * 9 / 10) << way;
    EXPECT_LE(visible, last) << way;
    last = visible;
    for (int step = 0; step < 6; ++step) {
      const auto picture = [&](const char* name) {
        return readPng(program_.folder / fmt::format("{}_{:03}.png", name, step));
      };
      const auto a = picture("none"), b = picture(way);
      ASSERT_EQ(a.rgba.size(), b.rgba.size());
      int most = 0;
      for (size_t i = 0; i < a.rgba.size(); ++i)
        most = std::max(most, std::abs(static_cast<int>(a.rgba[i]) - static_cast<int>(b.rgba[i])));
      EXPECT_LE(most, 13) << way << " step " << step;
    }
  }
}

TEST_F(CullingCommand, autoNeverPreparesAndMeasuresOnlyLongSeries) {
  const json unprepared = renderJson("--time 0:5 --culling auto -o a_%03d.png");
  EXPECT_FALSE(unprepared["culling_choice"]["culls"].get<bool>());
  EXPECT_THAT(unprepared["culling_choice"]["line"].get<std::string>(), HasSubstr("not prepared"));
  for (const json& frame : unprepared["frames"]) EXPECT_FALSE(frame.contains("culling"));
  const json made = program_.json(std::string("prepare mix_%03d.nrrd ") + kLook);
  EXPECT_EQ(made["state"], "built") << "auto left this to prepare";
  const json few = renderJson("--time 0:5 --culling auto -o b_%03d.png");
  EXPECT_FALSE(few["culling_choice"]["culls"].get<bool>());
  EXPECT_FALSE(few["culling_choice"].contains("seconds"));
  EXPECT_THAT(few["culling_choice"]["line"].get<std::string>(), HasSubstr("64 steps"));
  // One step is not measured either.
  EXPECT_EQ(render("--time 2 --culling auto -o one.png -q").status, 0);
}

// The faster way is taken for all pictures.
TEST_F(CullingCommand, autoTakesTheFasterWayForAllPictures) {
  EXPECT_EQ(program_.run("synth mixing -o long_%03d.nrrd --dims 32,32,32 --steps 66 -q").status, 0);
  EXPECT_EQ(program_.run(std::string("prepare -q long_%03d.nrrd ") + kLook).status, 0);
  const auto draw = [&](const char* how) {
    return program_.json(
        fmt::format("render long_%03d.nrrd {} {} --time 0:65 {}", kLook, kPicture, how));
  };
  const json chosen = draw("--culling auto -o auto_%03d.png");
  const json& choice = chosen["culling_choice"];
  const double none = choice["seconds"]["none"], toc = choice["seconds"]["toc"];
  EXPECT_GT(none, 0);
  EXPECT_GT(toc, 0);
  EXPECT_EQ(choice["culls"].get<bool>(), toc < 0.9 * none);
  EXPECT_EQ(chosen["frames"].size(), 66U);
  for (const json& frame : chosen["frames"])
    EXPECT_EQ(frame.contains("culling"), choice["culls"].get<bool>());
  draw(fmt::format("--culling {} -o same_%03d.png", choice["culls"].get<bool>() ? "toc" : "none")
           .c_str());
  for (const int step : {0, 1, 2, 3, 4, 5, 65})
    EXPECT_TRUE(readFile(program_.folder / fmt::format("auto_{:03}.png", step)) ==
                readFile(program_.folder / fmt::format("same_{:03}.png", step)))
        << step;
}

TEST_F(CullingCommand, rangesAndNumbers) {
  EXPECT_EQ(render("--time 1:5:2 -o a_%03d.png -q").status, 0);
  for (int step = 0; step < 6; ++step)
    EXPECT_EQ(program_.exists(fmt::format("a_{:03}.png", step)), step % 2 == 1) << step;
  EXPECT_EQ(render("--time 3 --culling toc -o one.png -q").status, 0);
  EXPECT_TRUE(program_.exists("one.png"));
  EXPECT_EQ(render("--time 5:1 -o b_%03d.png").status, 2);
  EXPECT_EQ(render("--time 1:5:0 -o b_%03d.png").status, 2);
  const CommandResult beyond = render("--time 2:6 -o b_%03d.png");
  EXPECT_EQ(beyond.status, 1);
  EXPECT_THAT(beyond.output, HasSubstr("--time 6: the volume has 6 time steps"));
  EXPECT_FALSE(program_.exists("b_002.png"));
  EXPECT_EQ(render("--time 0:5 --culling toc --mode mip -o b_%03d.png").status, 2);
  EXPECT_EQ(render("--time 0:5 --frames 4 -o b_%03d.png").status, 2);
}

TEST_F(CullingCommand, aFaultyStepIsNamedAndTheRestFollows) {
  EXPECT_EQ(render("--time 0:5 --culling toc -o whole_%03d.png -q").status, 0);
  const auto step = program_.folder / "mix_004.nrrd";
  const std::string whole = [&] {
    std::ifstream in(step, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  const auto rewrite = [&](const std::string& bytes) {
    std::ofstream(step, std::ios::binary) << bytes;
  };
  EXPECT_EQ(render("--time 0:3 -o f_%03d.png -q --this-step").status, 0);
  const auto before = std::filesystem::last_write_time(program_.folder / "f_003.png");
  // Truncated: named, in one line, and pictures drawn before stay.
  rewrite(whole.substr(0, whole.size() / 2));
  const CommandResult cut = render("--time 0:5 -o f_%03d.png -q --this-step --continue");
  EXPECT_EQ(cut.status, 1);
  EXPECT_THAT(cut.output, HasSubstr("mix_004.nrrd"));
  EXPECT_EQ(std::count(cut.output.begin(), cut.output.end(), '\n'), 1) << cut.output;
  EXPECT_FALSE(program_.exists("f_004.png"));
  // After repair, the missing pictures are drawn, and existing ones stay.
  rewrite(whole);
  EXPECT_EQ(render("--time 0:5 -o f_%03d.png -q --this-step --continue").status, 0);
  EXPECT_TRUE(program_.exists("f_005.png"));
  EXPECT_EQ(std::filesystem::last_write_time(program_.folder / "f_003.png"), before);
  // A file of another size.
  EXPECT_EQ(program_.run("synth mixing -o mix_004.nrrd --dims 40,48,48 -q --force").status, 0);
  const CommandResult sized = render("--time 0:5 --culling toc -o f_%03d.png -q");
  EXPECT_EQ(sized.status, 1);
  EXPECT_THAT(sized.output, HasSubstr("mix_004.nrrd: 40 x 48 x 48"));
  // Missing: the series is shorter, which is reported before anything is drawn.
  std::filesystem::remove(step);
  std::filesystem::remove(program_.folder / "mix_005.nrrd");
  const CommandResult missing = render("--time 0:5 -o g_%03d.png -q");
  EXPECT_EQ(missing.status, 1);
  EXPECT_THAT(missing.output, HasSubstr("mix_005.nrrd is missing"));
  EXPECT_EQ(std::count(missing.output.begin(), missing.output.end(), '\n'), 1) << missing.output;
  EXPECT_FALSE(program_.exists("g_000.png"));
}

TEST_F(CullingCommand, whatIsThereIsContinued) {
  EXPECT_EQ(render("--time 0:2 --culling toc -o c_%03d.png -q").status, 0);
  const auto before = std::filesystem::last_write_time(program_.folder / "c_001.png");
  const json rest = renderJson("--time 0:5 --culling toc --continue -o c_%03d.png");
  ASSERT_EQ(rest["frames"].size(), 3U);
  EXPECT_EQ(rest["frames"][0]["time"], 3);
  EXPECT_EQ(std::filesystem::last_write_time(program_.folder / "c_001.png"), before);
  EXPECT_TRUE(program_.exists("c_005.png"));
  const CommandResult nothing = render("--time 0:5 --culling toc --continue -o c_%03d.png");
  EXPECT_EQ(nothing.status, 0);
  EXPECT_THAT(nothing.output, HasSubstr("all 6 pictures are there"));
  const json none = renderJson("--time 0:5 --culling toc --continue -o c_%03d.png");
  EXPECT_TRUE(none["frames"].empty());
  EXPECT_EQ(none["command"], "render");
}

// Two layers, whose opacities are edited one by one.
TEST_F(CullingCommand, looksOfAFamilyNeedNoFunctionsOfTheirOwn) {
  const auto write = [&](const char* name, double low, double high) {
    std::ofstream(program_.folder / name)
        << fmt::format(R"({{"sluice_transfer_function": 1, "map": "grey", "opacities": )"
                       "[[0, 0], [60, 0], [60, {0}], [120, {0}], [120, {1}], [255, {1}]]}}",
                       low, high);
  };
  write("low.json", 0.5, 0);
  write("high.json", 0, 0.6);
  write("first.json", 0.5, 0.6);
  write("second.json", 1 - std::pow(0.5, 0.8), 1 - std::pow(0.4, 0.5));
  const auto prepare = [&](const char* look) {
    return program_.json(
        fmt::format("prepare mix_%03d.nrrd --transfer {} --basis "
                    "low.json,high.json --block 8 --no-shade",
                    look));
  };
  EXPECT_EQ(prepare("first.json")["state"], "built");
  const json second = prepare("second.json");
  EXPECT_EQ(second["state"], "read");
  EXPECT_NEAR(second["exponents"][0].get<double>(), 0.8, 0.02);
  EXPECT_NEAR(second["exponents"][1].get<double>(), 0.5, 0.02);
  const auto draw = [&](const std::string& how) {
    return program_.json(
        fmt::format("render mix_%03d.nrrd --transfer second.json --block 8 "
                    "--no-shade {} --time 0:5 {}",
                    kPicture, how));
  };
  draw("-o plain_%03d.png");
  const json own = draw("--culling toc -o own_%03d.png");
  const json culled = draw("--culling toc --basis low.json,high.json -o culled_%03d.png");
  int64_t visible = 0, nonempty = 0, of_own = 0;
  for (size_t step = 0; step < 6; ++step) {
    visible += culled["frames"][step]["culling"]["visible"].get<int64_t>();
    of_own += own["frames"][step]["culling"]["visible"].get<int64_t>();
    nonempty += culled["frames"][step]["culling"]["blocks_nonempty"].get<int64_t>();
    const auto a = readPng(program_.folder / fmt::format("plain_{:03}.png", step));
    const auto b = readPng(program_.folder / fmt::format("culled_{:03}.png", step));
    int most = 0;
    for (size_t i = 0; i < a.rgba.size(); ++i)
      most = std::max(most, std::abs(static_cast<int>(a.rgba[i]) - static_cast<int>(b.rgba[i])));
    EXPECT_LE(most, 13) << step;
  }
  EXPECT_LT(visible, nonempty);
  EXPECT_GE(visible, of_own) << "what is made for the look is no looser";
  const CommandResult odd = render("--culling toc --part 6 -o odd.png");
  EXPECT_EQ(odd.status, 1);
  EXPECT_THAT(odd.output, HasSubstr("--part 6"));
}

TEST_F(CullingCommand, benchHasTheNamesOfTheInterface) {
  const json report = program_.json(std::string("bench culling mix_%03d.nrrd --views 3 ") +
                                    "--threshold 100 --opacity 1 --block 8 --size 48");
  ASSERT_EQ(report["rows"].size(), 6U);
  for (const json& row : report["rows"]) {
    const json& visible = row["visible"];
    EXPECT_LE(visible["optimum"], visible["opof"]);
    EXPECT_LE(visible["opof"], visible["pof"]);
    EXPECT_EQ(visible["opof"], visible["toc"]);
    EXPECT_LE(visible["pof"], row["blocks_nonempty"]);
    EXPECT_LE(row["pixels_checked"]["toc"], row["pixels_checked"]["opof"]);
    EXPECT_TRUE(row["estimate_seconds"].contains("toc"));
  }
  ASSERT_EQ(report["fusion"].size(), 5U);
  for (size_t i = 1; i < 5; ++i) {
    EXPECT_GE(report["fusion"][i]["coherent_share"], report["fusion"][i - 1]["coherent_share"]);
    EXPECT_GE(report["fusion"][i]["visible_blocks"], report["fusion"][i - 1]["visible_blocks"]);
    EXPECT_LE(report["fusion"][i]["bytes"], report["fusion"][i - 1]["bytes"]);
  }
  for (const char* way : {"none", "opof", "toc"})
    EXPECT_GT(report["series_seconds"][way].get<double>(), 0);
  EXPECT_LT(report["series_read_bytes"]["toc"], report["series_read_bytes"]["none"]);
  EXPECT_EQ(report["views"].size(), 3U);
}

TEST_F(CullingCommand, aMissingBasisIsRefusedWithoutCullingToo) {
  for (const std::string command : {"render", "plan", "prepare", "bench culling"}) {
    const CommandResult result =
        program_.run(command + " " + kSmall + " --threshold 40 --basis nosuch.json" +
                     (command == "render" ? " -o b.png" : ""));
    EXPECT_EQ(result.status, 1) << command;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_THAT(result.output, HasSubstr("nosuch.json: ")) << command;
  }
  EXPECT_FALSE(program_.exists("b.png"));
}

}  // namespace
}  // namespace sluice
