#include "src/view/state/printed_command.h"

#include <gtest/gtest.h>

#include "src/base/files/shell_word.h"

namespace sluice {
namespace {

TEST(PrintedCommand, saysAllOfAView) {
  ViewedVolume volume;
  volume.paths = {"my head.raw"};
  volume.options.dims = std::array<int64_t, 3>{4, 5, 6};
  volume.options.type = "u8";
  ViewState state;
  state.view.look_at = ViewOptions::LookAt{{-1, 0, 9}, {0, 0, 0}};
  state.view.up = std::array{0.0, 1.0, 0.0};
  state.look.threshold = 40;
  state.background = std::array{1.0F, 0.0F, 0.5F};
  EXPECT_EQ(renderCommand(volume, state, "", 800, 600, "out.png"),
            "sluice render 'my head.raw' --dims=4,5,6 --type=u8 --threshold=40 --mode=composite "
            "--projection=ortho --eye=-1,0,9 --target=0,0,0 --up=0,1,0 --zoom=1 "
            "--background=ff0080 --size 800x600 -o out.png");
}

TEST(PrintedCommand, takesTheLookAsItIsDrawn) {
  ViewedVolume volume;
  volume.paths = {"a.nrrd"};
  ViewState state;
  state.look.mode = LookOptions::Mode::kMaximum;
  const std::string command =
      renderCommand(volume, state, "--map grey --range 0,255", 10, 10, "b.png");
  EXPECT_NE(command.find("a.nrrd --map grey --range 0,255 --mode=mip --projection"),
            std::string::npos)
      << command;
  state.look.channels = {{.channel = "1", .map = "green"}};
  EXPECT_EQ(renderCommand(volume, state, "--map grey --range 0,255", 10, 10, "b.png"), command);
}

// The program draws levels of another program on request alone, the window at once.
TEST(PrintedCommand, drawsTheLevelsOfAVolumeThatWasOpenedSoon) {
  ViewedVolume volume;
  volume.paths = {"a.zarr"};
  ViewState state;
  const auto asks = [&] {
    return renderCommand(volume, state, "", 10, 10, "b.png").find("--pixel-error=1") !=
           std::string::npos;
  };
  EXPECT_FALSE(asks());
  volume.options.opens_soon = true;
  EXPECT_TRUE(asks());
  state.look.labels = true;
  EXPECT_FALSE(asks()) << "drawn at level 0";
  state.look = {};
  state.look.mode = LookOptions::Mode::kMaximum;
  EXPECT_FALSE(asks());
}

TEST(PrintedCommand, saysPointsBesideTheFileOfTheirColours) {
  LookOptions look;
  look.transfer_file = "a.json";
  look.opacities = {{1, 0}, {2, 0.5}};
  const std::vector<OptionWord> words = lookWords(look);
  EXPECT_EQ(words[0], OptionWord("--transfer", "a.json"));
  EXPECT_EQ(words[1], OptionWord("--opacities", "1:0,2:0.5"));
}

// The program would warn of them, or refuse them.
TEST(PrintedCommand, leavesOutWhatDoesNotCount) {
  ViewState state;
  state.step_vox = 2;
  state.jitter = 1;
  state.quality = PictureOptions::Quality::kHigh;
  state.lighting.ambient = 0.5;
  state.lighting.depth_cueing = 1;
  state.look.opacity = 0.5;
  state.look.attenuation = 3;
  state.look.full_gradient = 0.2;
  state.look.light = LookOptions::Light::kOn;
  const auto said = [&](const std::string& look = "") {
    return renderCommand({}, state, look, 10, 10, "b.png");
  };
  for (const char* option : {"--step", "--jitter", "--quality", "--ambient", "--depth-cueing",
                             "--opacity", "--modulate", "--shade"})
    EXPECT_NE(said().find(option), std::string::npos) << option << ": " << said();
  EXPECT_EQ(said().find("--attenuation"), std::string::npos);
  EXPECT_EQ(said("--map ct-bone --no-shade").find("--ambient"), std::string::npos);
  state.look.mode = LookOptions::Mode::kMaximum;
  EXPECT_EQ(said(),
            "sluice render --mode=mip --projection=ortho --view=three-quarter --azimuth=0 "
            "--elevation=0 --zoom=1 --size 10x10 -o b.png");
  state.look.mode = LookOptions::Mode::kAttenuatedMaximum;
  EXPECT_NE(said().find("--attenuation=3"), std::string::npos) << said();
  EXPECT_NE(said().find("--step=2"), std::string::npos) << said();
}

TEST(PrintedCommand, namesChannelsOnce) {
  ViewedVolume volume;
  volume.paths = {"a.ome.zarr"};
  volume.options.channel_name = "2,0";
  const auto said = [&](const std::string& look) {
    return renderCommand(volume, {}, look, 10, 10, "b.png");
  };
  EXPECT_NE(said("").find("render a.ome.zarr --channel=2,0 "), std::string::npos) << said("");
  const std::string look = "--channel 2,0 --look 2:green --look 0:red";
  EXPECT_NE(said(look).find("render a.ome.zarr " + look + " "), std::string::npos) << said(look);
}

TEST(PrintedCommand, namesThatBeginAsOptionsAreFiles) {
  ViewedVolume volume;
  volume.paths = {"-a.nrrd"};
  const std::string command = renderCommand(volume, {}, "", 10, 10, "-o b.png");
  EXPECT_NE(command.find("render ./-a.nrrd "), std::string::npos) << command;
  EXPECT_NE(command.find("-o './-o b.png'"), std::string::npos) << command;
  EXPECT_EQ(framesCommand("it's.json", 3, 4, "f_%d.png"),
            "sluice render --state='it'\\''s.json' --size 3x4 -o f_%d.png");
}

TEST(PrintedCommand, quotesForAShell) {
  EXPECT_EQ(shellWord("a/b-1.nrrd"), "a/b-1.nrrd");
  EXPECT_EQ(shellWord("it's"), "'it'\\''s'");
  EXPECT_EQ(shellWord(""), "''");
  EXPECT_EQ(shellWord("$(rm)"), "'$(rm)'");
}

}  // namespace
}  // namespace sluice
