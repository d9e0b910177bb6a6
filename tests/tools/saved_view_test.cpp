// `sluice render` draws saved views, and names the file and field of what cannot be drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "tests/support/wrong_states.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

class SavedView : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(program_.folder / name, std::ios::binary) << bytes;
  }
  CommandResult render(const std::string& arguments) const {
    return program_.run("render " + arguments + " --device cpu --size 32 -q");
  }
  const Program program_;
};

// A part of the table that the parser and the window are tested with as a whole.
TEST_F(SavedView, wrongNumbersAreNamedByFileAndField) {
  write("view.json", rightState());
  EXPECT_EQ(render(std::string(kStateVolume) + " --state view.json -o a.png").output, "");
  const std::vector<WrongState> states = wrongStates();
  for (size_t i = 0; i < states.size(); i += 9) {
    if (states[i].field == "/cross") continue;  // a field of the window alone
    write("wrong.json", states[i].json);
    const CommandResult result =
        render(std::string(kStateVolume) + " --state wrong.json -o b_%d.png");
    EXPECT_EQ(result.status, 1) << states[i].json;
    EXPECT_THAT(result.output, HasSubstr("wrong.json: ")) << states[i].json;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  }
  EXPECT_FALSE(program_.exists("b_0.png"));
}

TEST_F(SavedView, slicesAreLeftOutWithAWarning) {
  const std::string shown = R"({"sluice": "view", "cross": [3, 4, 5], "slices": )";
  write("slices.json", shown + "true}");
  write("plain.json", shown + "false}");
  const auto said = [&](const std::string& file) {
    return program_
        .run("render " + std::string(kStateVolume) + " --size 32 --force -o a.png --state " + file)
        .output;
  };
  EXPECT_THAT(said("slices.json"), HasSubstr("sluice: warning: slices.json: \"slices\""));
  EXPECT_THAT(said("plain.json"), testing::Not(HasSubstr("warning")));
}

TEST_F(SavedView, conflictsOfTheUsersOptionsAloneAreTheUsers) {
  write("view.json", R"({"sluice": "view", "look": {"range": [0, 200]}})");
  const CommandResult light =
      render(std::string(kStateVolume) + " --state view.json --no-shade --shadows -o a.png");
  EXPECT_EQ(light.status, 2);
  EXPECT_EQ(light.output, "sluice: --shadows lights the picture; leave out --no-shade\n");
  // A fit has no effect beside a saved eye, as beside --eye.
  write("eye.json", R"({"sluice": "view", "camera": {"eye": [0, 0, 90], "target": [0, 0, 0]}})");
  const std::string fitted = std::string(kStateVolume) + " --state eye.json --fit volume -o a.png ";
  const CommandResult fit = render(fitted);
  EXPECT_EQ(fit.status, 2);
  EXPECT_THAT(fit.output, HasSubstr("sluice: --fit: eye.json has an eye and a target"));
  EXPECT_EQ(render(fitted + "--azimuth 20").status, 0) << "angles take the eye's place";
}

// The options of `render` have limits of their own. Values beyond them are no wrong usage.
TEST_F(SavedView, valuesBeyondAnOptionAreTheFiles) {
  const std::string volume = kStateVolume;
  const std::vector<std::pair<std::string, std::string>> wrong{
      {R"("look": {"map": "no such"})", "--map"},
      {R"("look": {"channels": ["0:red", "0:blue"]})", "--look"},
      {R"("volume": {"paths": ["a.nrrd"], "spacing": [1e13, 1, 1]})",
       "expected a number above 0, up to 1000000000000 at /volume/spacing/0"},
      {R"("volume": {"paths": ["a.raw"], "dims": [4611686018427387904, 1, 1]})",
       "expected a whole number from 1 to 1099511627776 at /volume/dims/0"},
      {R"("volume": {"paths": ["a.raw"], "channel": 1000000000000})",
       "expected a whole number from 0 to 1000000 at /volume/channel"}};
  for (const auto& [field, said] : wrong) {
    SCOPED_TRACE(field);
    write("wrong.json", R"({"sluice": "view", )" + field + "}");
    const CommandResult result =
        render((field.starts_with("\"volume") ? "" : volume + " ") + "--state wrong.json -o b.png");
    EXPECT_EQ(result.status, 1);
    EXPECT_THAT(result.output, testing::StartsWith("sluice: wrong.json: " + said));
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  }
}

TEST_F(SavedView, numbersBeyondTheVolumeAreTheFilesOrTheUsers) {
  write("late.json", R"({"sluice": "view", "time": 5})");
  write("large.json", R"({"sluice": "view", "crop": [0, 0, 0, 24, 20, 17]})");
  const std::string volume = kStateVolume;
  for (const char* output : {"a.png", "a_%d.png"}) {
    const std::string late = render(volume + " --state late.json -o " + output).output;
    EXPECT_THAT(late, HasSubstr("late.json: ")) << output;
    EXPECT_THAT(late, ContainsRegex("time (step )?(from 0 to 0|5: the volume has 1)"));
    EXPECT_THAT(render(volume + " --state large.json -o " + output).output,
                HasSubstr("large.json: expected at most the volume's 16 voxels at /crop/5"));
  }
  // The user's option takes the place of the file's number.
  EXPECT_EQ(render(volume + " --state late.json --time 0 -o b.png").output, "");
  EXPECT_EQ(render(volume + " --state large.json --crop 0,0,0,9,9,9 -o c.png").output, "");
}

TEST_F(SavedView, optionsThatItsVolumeCannotHaveAreTheFiles) {
  write("a.mhd",
        "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n12345678");
  const std::string volume = R"({"sluice": "view", "volume": {"paths": ["a.mhd"], )";
  write("grid.json", volume + R"("grid": "x"}})");
  write("channel.json", volume + R"("channel": 1}})");
  EXPECT_THAT(render("--state grid.json -o a.png").output,
              HasSubstr("sluice: grid.json: a.mhd: --grid x is for OpenVDB"));
  EXPECT_THAT(render("--state channel.json -o a.png").output,
              HasSubstr("sluice: channel.json: a.mhd: --channel 1 is for "));
  write("skip.json", volume + R"("skip": 5}})");
  EXPECT_THAT(render("--state skip.json -o a.png").output, HasSubstr("sluice: skip.json: a.mhd: "));
  // The user's own options are not the file's fault.
  EXPECT_THAT(render("--state grid.json --grid y -o a.png").output,
              HasSubstr("sluice: a.mhd: --grid y is for OpenVDB"));
}

TEST_F(SavedView, valuesWithoutEffectAreRefusedByTheirPlaces) {
  const auto refusal = [&](const std::string& json, const std::string& options = "") {
    write("view.json", R"({"sluice": "view", )" + json + "}");
    const CommandResult result =
        render(std::string(kStateVolume) + " --state view.json -o a.png " + options);
    EXPECT_EQ(result.status, 1) << json;
    return result.output;
  };
  EXPECT_EQ(refusal(R"("shadows": 0.5, "occlusion_light": 1, "look": {"light": "off"})"),
            "sluice: view.json: /shadows lights the picture; leave out /look/light off\n");
  EXPECT_EQ(refusal(R"("shadows": 0.5, "look": {"mode": "mip"})"),
            "sluice: view.json: /shadows needs /look/mode composite, since other modes are not "
            "lit\n");
  EXPECT_THAT(refusal(R"("look": {"labels": true, "mode": "average"})"),
              HasSubstr("view.json: /look/labels needs /look/mode composite"));
  EXPECT_THAT(refusal(R"("look": {"surfaces": ["20"], "mode": "mip"})"),
              HasSubstr("view.json: /look/surfaces needs /look/mode composite"));
  EXPECT_THAT(refusal(R"("path": {"kind": "keys", "keys": [{"jitter": 1, "look": {"mode": "mip"},
                      "camera": {"eye": [0, 0, 5], "target": [0, 0, 0]}}]})"),
              HasSubstr("view.json: /path/keys/0/jitter needs /path/keys/0/look/mode composite"));
  // The user's options count in place of the file's.
  EXPECT_THAT(refusal(R"("shadows": 0.5)", "--mode mip"),
              HasSubstr("view.json: /shadows needs --mode composite"));
  EXPECT_THAT(refusal(R"("look": {"mode": "mip"})", "--depth-cueing"),
              HasSubstr("view.json: --depth-cueing needs /look/mode composite"));
  EXPECT_THAT(refusal(R"("shadows": 0.5)", "--no-shade"),
              HasSubstr("view.json: /shadows lights the picture; leave out --no-shade"));
  EXPECT_EQ(render(std::string(kStateVolume) + " --state view.json --mode mip --shadows=0 -o a.png")
                .output,
            "");
  write("view.json", R"({"sluice": "view", "look": {"labels": true}})");
  EXPECT_EQ(render(std::string(kStateVolume) +
                   " --state view.json --mode mip --threshold 50 --force -o a.png")
                .output,
            "");
}

TEST_F(SavedView, keyFramesNeedNoUp) {
  write("film.json", R"({"sluice": "view", "path": {"kind": "keys", "keys": [
      {"seconds": 0.08, "camera": {"eye": [0, 0, 500], "target": [0, 0, 0]}},
      {"camera": {"eye": [500, 0, 0], "target": [0, 0, 0]}}]}})");
  EXPECT_EQ(render(std::string(kStateVolume) + " --state film.json -o f_%d.png").output, "");
  EXPECT_TRUE(program_.exists("f_2.png"));
}

// Two keys with one camera, and what the first and the second one have.
std::string filmOf(const std::string& first, const std::string& second,
                   const std::string& second_eye = "0, 0, 500") {
  return R"({"sluice": "view", "path": {"kind": "keys", "rate": 4, "keys": [
      {"seconds": 1, "camera": {"eye": [0, 0, 500], "target": [12, 10, 8]}, )" +
         first + R"(}, {"camera": {"eye": [)" + second_eye + R"(], "target": [12, 10, 8]}, )" +
         second + "}]}}";
}

TEST_F(SavedView, lightAndSurfacesChangeFromFrameToFrame) {
  for (const auto& [first, second] : std::vector<std::pair<std::string, std::string>>{
           {R"("depth_cueing": 0.1)", R"("depth_cueing": 1.0)"},
           {R"("look": {"light": "on"}, "ambient": 0.1)",
            R"("look": {"light": "on"}, "ambient": 0.9)"},
           {R"("look": {"surfaces": ["20:0.2"]})", R"("look": {"surfaces": ["20:1"]})"}}) {
    write("film.json", filmOf(first, second));
    ASSERT_EQ(render(std::string(kStateVolume) + " --state film.json --force -o f_%d.png").output,
              "");
    for (int i = 0; i < 4; ++i)
      EXPECT_NE(readFile(program_.folder / fmt::format("f_{}.png", i)),
                readFile(program_.folder / fmt::format("f_{}.png", i + 1)))
          << second << i;
  }
}

TEST_F(SavedView, anOptionThatStopsThePathIsNamed) {
  const std::string line =
      "render " + std::string(kStateVolume) + " --device cpu --size 32 --state film.json ";
  write("film.json", filmOf(R"("time": 0)", R"("time": 0)", "500, 0, 0"));
  const CommandResult same = program_.run(line + "-o f_%d.png --azimuth 30");
  EXPECT_EQ(same.status, 1);
  EXPECT_EQ(
      same.output,
      "sluice: film.json: with --azimuth in place of the path's own values, all of its frames "
      "are the same; give fewer options, or give -o a name without a number for one "
      "picture\n");
  EXPECT_FALSE(program_.exists("f_0.png"));
  EXPECT_EQ(program_.run(line + "-o one.png --azimuth 30 -q").output, "");
  // Something else still changes.
  write("film.json", filmOf(R"("step": 1)", R"("step": 4)", "500, 0, 0"));
  EXPECT_THAT(program_.run(line + "-o f_%d.png --azimuth 30").output,
              HasSubstr("warning: film.json: --azimuth: one camera shows all frames"));
  EXPECT_NE(readFile(program_.folder / "f_0.png"), readFile(program_.folder / "f_4.png"));
}

// An option of the look replaces that option in all frames, and no other.
TEST_F(SavedView, framesKeepTheRestOfTheirLooks) {
  write("film.json", filmOf(R"("look": {"threshold": 10, "opacity": 0.5})",
                            R"("look": {"threshold": 60, "opacity": 0.1})"));
  const std::string line = std::string(kStateVolume) + " --state film.json --force -o f_%d.png ";
  ASSERT_EQ(render(line + "--opacity 0.2").output, "");
  EXPECT_NE(readFile(program_.folder / "f_0.png"), readFile(program_.folder / "f_4.png"));
  EXPECT_THAT(render(line + "--opacity 0.2 --threshold 40").output,
              HasSubstr("film.json: with --threshold, --opacity in place"));
}

TEST_F(SavedView, numbersThatJumpAreNamed) {
  write("film.json", filmOf(R"("step": 1)", R"("crop": [0, 0, 0, 9, 9, 9])", "500, 0, 0"));
  const std::string line =
      "render " + std::string(kStateVolume) + " --device cpu --size 32 --state film.json --force ";
  EXPECT_THAT(program_.run(line + "-o f_%d.png").output,
              HasSubstr("warning: film.json: /step, /crop: set in some key frames only"));
  EXPECT_THAT(program_.run(line + "-o f_%d.png --step 1 --crop 0,0,0,9,9,9").output,
              testing::Not(HasSubstr("key frames only")));
}

TEST_F(SavedView, looksOfKeysAreCheckedBeforeTheFirstFrame) {
  for (const auto& [look, said] : std::vector<std::pair<std::string, std::string>>{
           {R"("transfer": "none.json")", "none.json: cannot be read"},
           {R"("map": "nosuch")", "expected one of viridis"},
           {R"("channels": ["3:red"])", "that channel is not shown"}}) {
    write("film.json", filmOf(R"("time": 0)", R"("look": {)" + look + "}"));
    const std::string output =
        render(std::string(kStateVolume) + " --state film.json -o f_%d.png").output;
    EXPECT_THAT(output, testing::StartsWith("sluice: film.json: /path/keys/1: "));
    EXPECT_THAT(output, HasSubstr(said));
    EXPECT_FALSE(program_.exists("f_0.png")) << look;
  }
}

TEST_F(SavedView, framesOfAPathRefuseTheOptionsOfOnePicture) {
  write("film.json", R"({"sluice": "view", "path": {"kind": "turn", "frames": 2}})");
  const std::string line = std::string(kStateVolume) + " --state film.json -o f_%d.png ";
  for (const std::string option :
       {"--algorithm merged", "--level 0", "--level 1", "--levels none", "--pixel-error 2",
        "--max-bytes 1M", "--keep-thin", "--time-limit 1", "--opacity-threshold 0.5",
        "--progressive", "--merge paper", "--verify"}) {
    const CommandResult result = render(line + option);
    EXPECT_EQ(result.status, 1) << option;
    EXPECT_EQ(result.output,
              "sluice: " + option.substr(0, option.find(' ')) +
                  ": frames of the path in film.json do not take it; give -o a name without a "
                  "number for one picture\n");
  }
  EXPECT_FALSE(program_.exists("f_0.png"));
  const CommandResult rate =
      program_.run("render " + line + "--size 32 --rate 5 2>&1 >out && ls f_0.png f_1.png");
  EXPECT_EQ(rate.status, 0);
  EXPECT_THAT(rate.output, HasSubstr("warning: --rate changes nothing without a film"));
}

TEST_F(SavedView, aVolumeWhoseNameIsNoUtf8IsFound) {
  ASSERT_EQ(program_.run("synth shells --dims 12x12x12 -o plain.nrrd -q").status, 0);
  std::filesystem::rename(program_.folder / "plain.nrrd", program_.folder / "caf\xe9.nrrd");
  write("view.json", R"({"sluice": "view", "volume": {"paths": [{"bytes": "caf\u00e9.nrrd"}]}})");
  EXPECT_EQ(render("--state view.json -o a.png").output, "");
  EXPECT_TRUE(program_.exists("a.png"));
}

// Its range is one value, which --range does not take.
TEST_F(SavedView, theOptionsOfAConstantVolumeDrawItAgain) {
  write("flat_8x8x8_uint8.raw", std::string(512, '*'));
  const std::string render = "render flat_8x8x8_uint8.raw --device cpu --size 32 -o ";
  for (const std::string mode : {"mip", "minip", "average", "composite"}) {
    const std::string look =
        program_.json(render + "a.png --mode " + mode).at("look").at("options");
    const CommandResult again = program_.run(render + "b.png -q --mode " + mode + " " + look);
    EXPECT_EQ(again.output, "") << mode << ": " << look;
    EXPECT_EQ(readFile(program_.folder / "a.png"), readFile(program_.folder / "b.png")) << look;
  }
}

}  // namespace
}  // namespace sluice
