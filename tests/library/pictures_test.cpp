// Pictures of the library equal those of the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tests/library/library_support.h"

namespace sluice {
namespace {

// Each by other ways than the program's own parsing of the same.
TEST(Renderer, picturesAreThoseOfTheProgram) {
  using From = ViewOptions::From;
  struct Case {
    LookOptions look;
    PictureOptions picture;
    std::string look_arguments, picture_arguments;
  };
  PictureOptions plain = kSmall, turned = kSmall, deep = kSmall, cropped = kSmall, fitted = kSmall,
                 looks_at = kSmall;
  plain.view.from = From::kPlain;
  plain.step_vox = 1;
  turned.view = {.from = From::kTop, .azimuth_deg = 33, .elevation_deg = 12, .zoom = 1.3};
  deep.view.projection = ViewOptions::Projection::kPerspective;
  deep.view.field_of_view_deg = 45;
  deep.view.up = {{1, 0, 0}};
  cropped.crop = {{{4, 5, 6}, {40, 30, 31}}};
  fitted.view.fit = ViewOptions::Fit::kVolume;
  looks_at.view.look_at = {{{100, 80, 60}, {20, 20, 20}}};
  const std::vector<Case> cases = {
      {{}, kSmall, "", ""},
      {{.threshold = 90}, plain, "--threshold 90", "--view plain --step 1"},
      {{.threshold = 90, .opacity = 0.3, .map = "viridis", .light = LookOptions::Light::kOff},
       turned,
       "--threshold 90 --opacity 0.3 --map viridis --no-shade",
       "--view top --azimuth 33 --elevation 12 --zoom 1.3"},
      {{.opacities = {{60, 0}, {200, 0.4}}, .range = {{200, 10}}},
       deep,
       "--opacities 60:0,200:0.4 --range 200,10",
       "--projection perspective --fov 45 --up 1,0,0"},
      {{.mode = LookOptions::Mode::kMaximum}, cropped, "", "--mode mip --crop 4,5,6,40,30,31"},
      {{.mode = LookOptions::Mode::kAverage}, fitted, "", "--mode average --fit volume"},
      {{.threshold = 60, .full_gradient = 0.2},
       looks_at,
       "--threshold 60 --modulate --full-gradient 0.2",
       "--eye 100,80,60 --target 20,20,20"}};
  const TempFolder folder;
  const Volume volume(kShells);
  Renderer renderer(volume);
  for (const auto& [look, picture, look_arguments, picture_arguments] : cases) {
    renderer.setLook(look);
    const std::vector<uint8_t> drawn = renderer.draw(picture).toRgba8();
    EXPECT_GT(visiblePixels(drawn), 500U);
    // The second turn: its look as text gives the same once more.
    for (const std::string& arguments : {look_arguments, renderer.lookText()}) {
      SCOPED_TRACE(arguments + " " + picture_arguments);
      const Rgba8Picture expected = programPicture(
          folder, std::string(kShells) + " --size 96x80 " + arguments + " " + picture_arguments);
      EXPECT_LE(largestDifference(drawn, expected.rgba), 1);
    }
  }
}

// Rows from the top down are those of the picture, whether it is drawn in strips or whole, and so
// is the file.
TEST(Renderer, rowsAndFilesAreThoseOfThePicture) {
  const TempFolder folder;
  const Volume volume(kShells);
  PictureOptions large;
  large.width = 700;
  large.height = 611;
  constexpr std::array<float, 3> kGrey{0.2F, 0.3F, 0.4F};
  Image whole;
  std::string file;
  for (const uint64_t memory : {uint64_t{1} << 30, uint64_t{24} << 20}) {
    RendererOptions options{.memory_bytes = memory};
    options.rows_width = large.width;
    options.rows_height = large.height;
    Renderer renderer(volume, {.threshold = 90}, options);
    if (whole.rgba.empty()) whole = renderer.draw(large);
    std::vector<float> rgba;
    int height = 0, pieces = 0;
    renderer.drawRows(large, [&](const Image& rows) {
      EXPECT_EQ(rows.width, large.width);
      rgba.insert(rgba.end(), rows.rgba.begin(), rows.rgba.end());
      height += rows.height;
      ++pieces;
    });
    EXPECT_EQ(height, large.height);
    EXPECT_GT(pieces, 1);
    EXPECT_TRUE(rgba == whole.rgba) << memory;
    renderer.drawToFile((folder / "a.png").string(), large, kGrey);
    whole.writePng((folder / "b.png").string(), kGrey);
    EXPECT_TRUE(readFile(folder / "a.png") == readFile(folder / "b.png")) << memory;
    EXPECT_EQ(renderer.report().why_empty, "");
    EXPECT_THROW(renderer.drawToFile((folder / "a.gif").string(), large), Error);
    large.with_depth = true;
    renderer.writeExr((folder / "b.exr").string(), renderer.draw(large), large);
    large.with_depth = false;
    renderer.drawToFile((folder / "a.exr").string(), large);
    EXPECT_TRUE(readFile(folder / "a.exr") == readFile(folder / "b.exr")) << memory;
  }
}

// Levels of resolution: the default, a level, and pictures that means cannot show; in a series,
// too.
TEST(Renderer, levelsOfResolutionAreThoseOfTheProgram) {
  const std::string series = "synth:mixing,dims=90x80x70,steps=2,levels=3";
  struct Case {
    LookOptions look;
    double pixel_error = 1;
    std::optional<int> level;
    std::string arguments;
    bool is_coarse = true;
  };
  const std::vector<Case> cases = {
      {{.threshold = 90}, 1, {}, "--threshold 90"},
      {{.threshold = 90}, 8, {}, "--threshold 90 --pixel-error 8"},
      {{.threshold = 90}, 1, 1, "--threshold 90 --level 1"},
      {{.threshold = 90}, 1, 0, "--threshold 90 --level 0", false},
      {{.mode = LookOptions::Mode::kMaximum}, 1, {}, "--mode mip", false}};
  const TempFolder folder;
  const Volume volume(series, {.index_folder = folder / "index"});
  Renderer renderer(volume);
  for (const Case& one : cases)
    for (const int64_t time : {1, 0}) {
      SCOPED_TRACE(one.arguments + " " + std::to_string(time));
      renderer.setLook(one.look);
      const PictureOptions picture{.width = 30,
                                   .height = 26,
                                   .time = time,
                                   .pixel_error = one.pixel_error,
                                   .level = one.level};
      const std::vector<uint8_t> drawn =
          renderer.draw(picture).toRgba8(std::array<float, 3>{0, 0, 0});
      EXPECT_EQ(renderer.report().coarse_share, one.is_coarse ? 1.0 : 0.0);
      const RenderReport report = renderer.report(true);
      EXPECT_GT(std::ranges::count_if(report.block_classes, [](uint8_t kind) { return kind > 0; }),
                0);
      const Rgba8Picture expected =
          programPicture(folder, series + " --size 30x26 --background 000000 --time " +
                                     std::to_string(time) + " " + one.arguments);
      EXPECT_LE(largestDifference(drawn, expected.rgba), 1);
    }
  PictureOptions missing = kSmall;
  missing.level = 7;
  EXPECT_THROW(renderer.draw(missing), Error);
  missing.level = {};
  missing.pixel_error = 0;
  EXPECT_THROW(renderer.draw(missing), Error);
}

TEST(Renderer, picturesWithATimeLimitBeginCoarseAndEndAsTheOneWithout) {
  const std::string shells = "synth:shells,dims=120x110x100,levels=4";
  const Volume volume(shells);
  EXPECT_EQ(volume.info().levels, 4);
  const LookOptions look{.threshold = 90};
  PictureOptions picture = kSmall;
  const Image whole = Renderer(volume, look).draw(picture);
  EXPECT_FALSE(whole.will_improve);
  Renderer renderer(volume, look);
  picture.time_limit_s = 0;
  Image image = renderer.draw(picture);
  EXPECT_TRUE(image.will_improve);
  EXPECT_EQ(image.missing_share, 0.0);
  EXPECT_EQ(renderer.report().levels, std::vector<int>{3});
  EXPECT_FALSE(renderer.report().is_refined);
  // All of the volume shows from the first picture on.
  size_t visible = 0, visible_in_both = 0;
  for (size_t i = 3; i < whole.rgba.size(); i += 4) {
    visible += whole.rgba[i] > 0.01F ? 1 : 0;
    visible_in_both += whole.rgba[i] > 0.01F && image.rgba[i] > 0 ? 1 : 0;
  }
  EXPECT_GT(visible, 1000U);
  EXPECT_GT(static_cast<double>(visible_in_both), 0.99 * static_cast<double>(visible));
  picture.time_limit_s = 0.1;
  for (int i = 0; image.will_improve; ++i) {
    ASSERT_LT(i, 1000);
    image = renderer.draw(picture);
    EXPECT_EQ(image.missing_share, 0.0);
  }
  EXPECT_EQ(image.rgba, whole.rgba);
  EXPECT_TRUE(renderer.report().is_refined);
  EXPECT_FALSE(renderer.report().will_improve);
}

TEST(Renderer, theSamplingOfAPictureIsKnownBeforeItIsDrawn) {
  const Volume volume("synth:shells,dims=120x110x100,levels=4");
  const std::vector<LookOptions> looks = {
      {.threshold = 90, .light = LookOptions::Light::kOn},
      {.threshold = 90, .light = LookOptions::Light::kOff},
      {.surfaces = {{.value = 90}}},
      {.mode = LookOptions::Mode::kAverage},
      {.label_looks = {{.first = 90, .last = 90, .color = "green"}}}};
  std::vector<PictureOptions> pictures(5, kSmall);
  pictures[1].view.zoom = 20;
  pictures[2].level = 0;
  pictures[3].quality = PictureOptions::Quality::kHigh;
  pictures[4].step_vox = 3;
  for (size_t i = 0; i < looks.size(); ++i) {
    Renderer renderer(volume, looks[i]);
    for (size_t j = 0; j < pictures.size(); ++j) {
      SCOPED_TRACE(testing::Message() << "look " << i << ", picture " << j);
      const PictureSampling sampling = renderer.sampling(pictures[j]);
      renderer.draw(pictures[j]);
      const bool is_cut_short = !looks[i].surfaces.empty() && pictures[j].step_vox;
      EXPECT_EQ(is_cut_short ? 1 : sampling.step_vox, renderer.report().step_vox);
      EXPECT_EQ(sampling.from_levels, !renderer.report().levels.empty());
    }
  }
}

TEST(Renderer, aTurnHasOneFramingAsTheProgramsHas) {
  const TempFolder folder;
  const Volume volume(kShells);
  Renderer renderer(volume, {.threshold = 90});
  std::vector<PictureOptions> turn(3, kSmall);
  for (size_t i = 0; i < 3; ++i) turn[i].view.azimuth_deg = 120.0 * static_cast<double>(i);
  renderer.fit(turn);
  for (size_t i = 0; i < 3; ++i) {
    const Rgba8Picture expected =
        programPicture(folder, std::string(kShells) + " --size 96x80 --threshold 90 --frames 3",
                       "turn_#.png", "turn_" + std::to_string(i) + ".png");
    EXPECT_LE(largestDifference(renderer.draw(turn[i]).toRgba8(), expected.rgba), 1) << i;
  }
  renderer.fit({});
}

TEST(Renderer, drawsEachStepOfASeriesInOneLook) {
  const std::string series = "synth:flow,dims=40x40x40,steps=3";
  const TempFolder folder;
  const Volume volume(series, {.index_folder = folder / "index"});
  ASSERT_EQ(volume.info().time_steps, 3);
  Renderer renderer(volume);
  for (const int64_t time : {2, 0, 1, 2}) {
    PictureOptions picture = kSmall;
    picture.time = time;
    const Rgba8Picture expected =
        programPicture(folder, series + " --size 96x80 --time " + std::to_string(time));
    EXPECT_LE(largestDifference(renderer.draw(picture).toRgba8(), expected.rgba), 1) << time;
  }
  const Volume one_step(series, {.whole_series = false, .time = 1});
  Renderer alone(one_step);
  PictureOptions picture = kSmall;
  picture.time = 1;
  const Rgba8Picture expected =
      programPicture(folder, series + " --size 96x80 --time 1 --this-step");
  EXPECT_LE(largestDifference(alone.draw(picture).toRgba8(), expected.rgba), 1);
}

TEST(Renderer, depthIsThatOfTheOpaqueSurface) {
  const Volume volume("synth:cube,dims=32x32x32");
  Renderer renderer(volume, {.opacities = {{100, 0}, {100, 1}}});
  PictureOptions picture = kSmall;
  picture.view.look_at = {{{16, 16, 116}, {16, 16, 16}}};
  picture.with_depth = true;
  const Image image = renderer.draw(picture);
  ASSERT_EQ(image.depth.size(), 96U * 80U);
  const float middle = image.depth[40 * 96 + 48];
  EXPECT_GT(middle, 84);
  EXPECT_LT(middle, 116);
  EXPECT_TRUE(std::isinf(image.depth[0]));
}

}  // namespace
}  // namespace sluice
