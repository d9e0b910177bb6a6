#include "src/view/state/files/state_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/error_of.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;

ViewState everything() {
  ViewState state;
  state.view.look_at = ViewOptions::LookAt{{1.5, -2, 1.0 / 3}, {0, 0.1, 7}};
  state.view.up = std::array{0.0, 0.6, 0.8};
  state.view.projection = ViewOptions::Projection::kPerspective;
  state.view.zoom = 1.25;
  state.view.field_of_view_deg = 40;
  state.look.mode = LookOptions::Mode::kAverage;
  state.look.opacities = {{-3, 0}, {0.1, 1.0 / 7}};
  state.look.map = "viridis";
  state.look.range = std::array{5.0, -5.0};
  state.look.light = LookOptions::Light::kOff;
  state.look.full_gradient = 0.07;
  state.time = 3;
  state.step_vox = 0.3;
  state.quality = PictureOptions::Quality::kHigh;
  state.lighting = {std::array{40.0, -20.0}, 0.1, 0.8, 0.5};
  state.crop = PictureOptions::Box{{1, 2, 3}, {4, 5, 6}};
  state.clip_planes = {{{0, 0, 1}, 2.5}, {{1, 0, 0}, -1}};
  state.background = std::array{0.0F, 0.5F, 1.0F};
  state.cross = {4, 5, 6};
  state.shows_slices = true;
  return state;
}

TEST(StateFile, givesBackWhatWasSaved) {
  ViewedVolume volume;
  volume.paths = {"synth:shells,dims=48x40x36"};
  volume.options.dims = std::array<int64_t, 3>{1, 2, 3};
  volume.options.type = "u16";
  volume.options.big_endian = true;
  const StateFile read = parseState(stateText(volume, everything()), "here");
  EXPECT_EQ(read.state, everything());
  ASSERT_TRUE(read.volume);
  EXPECT_EQ(read.volume->paths, volume.paths);
  EXPECT_EQ(read.volume->options.dims, volume.options.dims);
  EXPECT_EQ(read.volume->options.type, "u16");
  EXPECT_TRUE(read.volume->options.big_endian);
}

TEST(StateFile, namesThatAreNoUtf8AreKeptByteForByte) {
  std::string every;
  for (int byte = 1; byte < 256; ++byte)
    if (byte != '/') every += static_cast<char>(byte);
  ViewedVolume volume;
  volume.paths = {"caf\xe9.nrrd", every, "caf\xc3\xa9.nrrd"};  // Latin-1, anything, UTF-8
  volume.options.channel_name = "K\xe4se";
  volume.options.grid = "dichte \xff";
  ViewState state;
  state.look.transfer_file = "gr\xfcn.json";
  const std::string text = stateText(volume, state);
  const StateFile read = parseState(text, "here");
  EXPECT_EQ(read.volume->paths, volume.paths);
  EXPECT_EQ(read.volume->options.channel_name, volume.options.channel_name);
  EXPECT_EQ(read.volume->options.grid, volume.options.grid);
  EXPECT_EQ(read.state.look.transfer_file, state.look.transfer_file);
  EXPECT_THAT(text, HasSubstr("\"caf\xc3\xa9.nrrd\""));  // not escaped
  EXPECT_THAT(errorOf([&] {
                parseState(R"({"sluice": "view", "look": {"transfer": {"bytes": "\u0100"}}})", "a");
              }),
              HasSubstr("up to U+00FF"));
}

TEST(StateFile, keepsThePathOfAFilm) {
  ViewPath path;
  path.kind = ViewPath::Kind::kKeys;
  path.frames_per_second = 12.5;
  path.turn_frames = 33;
  path.keys = {{everything(), 0.7}, {everything(), 3}};
  path.keys[1].state.look = {};
  path.keys[1].state.look.transfer_file = "t.json";
  path.keys[1].state.look.surfaces = {{12.5, 0.4, "ff8800"}, {40, 1, ""}};
  for (ViewKey& key : path.keys) {
    key.state.cross = {};  // no part of a film
    key.state.shows_slices = false;
  }
  const StateFile read = parseState(stateText({}, everything(), path), "here");
  EXPECT_EQ(read.path, path);
  EXPECT_EQ(read.state, everything());
  EXPECT_FALSE(parseState(stateText({}, everything()), "here").path);
}

TEST(StateFile, hasNoValueWithoutEffect) {
  ViewState state;
  state.look.mode = LookOptions::Mode::kMaximum;
  state.look.surfaces = {{12.5, 0.4, "ff8800"}};
  state.lighting.shadows = 0.5;
  state.jitter = 1;
  const ViewState read = parseState(stateText({}, state), "here").state;
  EXPECT_TRUE(read.look.surfaces.empty());
  EXPECT_EQ(read.lighting.shadows, 0);
  EXPECT_EQ(read.jitter, 0);
}

TEST(StateFile, saysWhatIsWrongWithAPath) {
  const auto said = [](const std::string& text) {
    return errorOf([&] { parseState(R"({"sluice": "view", "path": )" + text + "}", "a.json"); });
  };
  EXPECT_THAT(said("[]"), HasSubstr("a.json"));
  EXPECT_THAT(said(R"({"kind": "spin"})"), HasSubstr("one of turn, keys"));
  EXPECT_THAT(said(R"({"kind": "turn", "frames": 0})"), HasSubstr("1 to 100000 frames"));
  EXPECT_THAT(said(R"({"kind": "keys"})"), HasSubstr("keys"));
  EXPECT_THAT(said(R"({"kind": "keys", "keys": [{"time": 0}]})"), HasSubstr("eye and target"));
  EXPECT_THAT(said(R"({"kind": "keys", "rate": 0, "keys": []})"), HasSubstr("above 0"));
  const std::string key = R"({"seconds": 1e5, "camera": {"eye": [0, 0, 1], "target": [0, 0, 0]}})";
  EXPECT_THAT(said(R"({"kind": "keys", "keys": [)" + key + "," + key + "]}"),
              HasSubstr("at most 100000 frames"));
}

// The window may save names that are no UTF-8 as objects, but nothing else.
TEST(StateFile, looksOfPartsAreTexts) {
  const auto said = [](const std::string& look) {
    return errorOf([&] { parseState(R"({"sluice": "view", "look": {)" + look + "}}", "a.json"); });
  };
  EXPECT_EQ(said(R"("surfaces": [{"value": 40}])"),
            "a.json: expected a surface as a text, such as \"300:0.4:ff8800\" at "
            "/look/surfaces/0, found an object of 1");
  EXPECT_THAT(said(R"("surfaces": [40])"), HasSubstr("as a text, such as \"300:0.4:ff8800\""));
  EXPECT_THAT(said(R"("label_looks": [{"first": 3}])"), HasSubstr("such as \"3=ff8800:0.4\""));
  EXPECT_THAT(said(R"("channels": [{}])"), HasSubstr("such as \"0:green,400:3000,0.1\""));
  const StateFile read = parseState(
      R"({"sluice": "view", "look": {"channels": [{"bytes": "caf\u00e9:green"}]}})", "a.json");
  EXPECT_EQ(read.state.look.channels.front().channel, "caf\xe9");
}

TEST(StateFile, anEmptyStateIsTheDefault) {
  const StateFile read = parseState(R"({"sluice": "view"})", "here");
  EXPECT_EQ(read.state, ViewState());
  EXPECT_FALSE(read.volume);
}

TEST(StateFile, namesOfFilesBecomeAbsolute) {
  const TempFolder folder;
  const std::filesystem::path file = folder / "a.json";
  ViewedVolume volume;
  volume.paths = {file.string()};
  std::ofstream(file) << stateText(volume, {});
  EXPECT_EQ(readState(file).volume->paths.front(), std::filesystem::absolute(file).string());
}

// A saved view may be opened from another folder.
TEST(StateFile, tablesOfChannelsBecomeAbsolute) {
  const TempFolder folder;
  const std::filesystem::path file = folder / "a.json", table = folder / "\xff bones.txt";
  std::ofstream(table) << "1 255 0 0 1 1 1 \"bone\"\n";
  const std::string relative = std::filesystem::relative(table).string();
  ASSERT_NE(relative, std::filesystem::absolute(table).string());
  ViewState state;
  state.look.channels = {{.channel = "0", .map = relative, .opacity = 0.5},
                         {.channel = "1", .map = "green"},
                         {.channel = "2", .map = "missing.txt"}};
  std::ofstream(file) << stateText({}, state);
  const auto channels = readState(file).state.look.channels;
  ASSERT_EQ(channels.size(), 3U);
  EXPECT_EQ(channels[0].map, std::filesystem::absolute(relative).string());
  EXPECT_EQ(channels[0].opacity, 0.5);
  EXPECT_EQ(channels[1].map, "green");
  EXPECT_EQ(channels[2].map, "missing.txt");
}

TEST(StateFile, saysWhatIsWrongAndWhere) {
  const auto said = [](const std::string& text) {
    return errorOf([&] { parseState(text, "a.json"); });
  };
  EXPECT_THAT(said("{}"), HasSubstr("a.json: expected a view's state"));
  EXPECT_THAT(said("[1]"), HasSubstr("a.json: expected a view's state"));
  EXPECT_THAT(said(R"({"sluice": "view", "colour": 1})"), HasSubstr("colour"));
  EXPECT_THAT(said(R"({"sluice": "view", "look": {"mode": "max"}})"), HasSubstr("composite"));
  EXPECT_THAT(said(R"({"sluice": "view", "crop": [1, 2]})"), HasSubstr("6 numbers"));
  for (const char* other :
       {R"("azimuth": 0)", R"("elevation": 9)", R"("view": "top")", R"("fit": "volume")"}) {
    const std::string key = std::string(other).substr(1, std::string(other).find(':') - 2);
    const std::string camera =
        R"("camera": {"eye": [0, 0, 9], "target": [0, 0, 0], )" + std::string(other) + "}";
    EXPECT_THAT(
        said(R"({"sluice": "view", )" + camera + "}"),
        HasSubstr(R"(expected no value beside "eye" and "target", which replace it, at /camera/)" +
                  key));
    EXPECT_THAT(said(R"({"sluice": "view", "path": {"kind": "keys", "keys": [{)" + camera + "}]}}"),
                HasSubstr("at /path/keys/0/camera/" + key));
  }
  // These exclude each other on a command line, too.
  for (const auto& [keys, one, other] :
       {std::tuple(R"("opacities": [[1, 0], [2, 1]], "threshold": 3)", "threshold", "opacities"),
        std::tuple(R"("transfer": "a.json", "threshold": 3)", "threshold", "transfer"),
        std::tuple(R"("opacities": [[1, 0], [2, 1]], "opacity": 1)", "opacities", "opacity"),
        std::tuple(R"("labels": true, "threshold": 3)", "threshold", "labels"),
        std::tuple(R"("label_looks": ["1=red"], "transfer": "a")", "transfer", "label_looks"),
        std::tuple(R"("surfaces": ["3"], "label_table": "a")", "surfaces", "label_table")}) {
    const std::string look = R"("look": {)" + std::string(keys) + "}";
    const std::string expected =
        fmt::format("expected no value beside \"{}\", of which one is to be left out, at", one);
    EXPECT_THAT(said(R"({"sluice": "view", )" + look + "}"),
                HasSubstr(fmt::format("{} /look/{}", expected, other)));
    EXPECT_THAT(said(R"({"sluice": "view", "path": {"kind": "keys", "keys": [{)" + look + "}]}}"),
                HasSubstr(fmt::format("{} /path/keys/0/look/{}", expected, other)));
  }
  EXPECT_NO_THROW(parseState(
      R"({"sluice": "view", "look": {"labels": false, "surfaces": [], "threshold": 3}})", "a"));
  // A view is saved without them.
  ViewState both;
  both.look.threshold = 3;
  both.look.opacity = 0.5;
  both.look.labels = true;
  both.look.opacities = {{1, 0}, {2, 1}};
  const ViewState read = parseState(stateText({}, both, {}), "a").state;
  EXPECT_EQ(read.look.opacities, both.look.opacities);
  EXPECT_TRUE(!read.look.threshold && !read.look.opacity && !read.look.labels);
  EXPECT_THAT(said(R"({"sluice": "view", "camera": {"eye": [1, 2, 3]}})"),
              HasSubstr("eye and target together"));
  const auto ofVolume = [&](const std::string& fields) {
    return said((R"({"sluice": "view", "volume": {)" + fields + "}}").c_str());
  };
  // The system would open a.raw.
  for (const char* path : {R"("a.raw\u0000b")", R"({"bytes": "a.raw\u0000b"})"})
    EXPECT_THAT(ofVolume(std::string(R"("paths": [)") + path + "]"),
                HasSubstr("a.json: expected a name without a zero byte at /volume/paths/0"));
  EXPECT_THAT(ofVolume(R"("paths": [""])"), HasSubstr("not empty at /volume/paths/0"));
  for (const std::string name : {"grid", "channel", "over"})
    EXPECT_THAT(ofVolume(R"("paths": ["a.raw"], ")" + name + R"(": "")"),
                HasSubstr("not empty at /volume/" + name));
  EXPECT_THAT(said(R"({"sluice": "view", "look": {"transfer": ""}})"),
              HasSubstr("not empty at /look/transfer"));
  EXPECT_THAT(ofVolume(R"("paths": ["a.raw"], "time_steps": 3)"),
              HasSubstr("at /volume/time_steps, found 3"));
  EXPECT_THAT(said(R"({"sluice": "view", "look": {"opacities": [[2, 0], [1, 0]]}})"),
              HasSubstr("ascend"));
}

}  // namespace
}  // namespace sluice
