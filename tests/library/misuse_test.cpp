// Impossible calls throw, and the next call is right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "tests/library/library_support.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

TEST(Renderer, valuesWithoutEffectThrow) {
  const Volume volume(kShells);
  const LookOptions surface{.surfaces = {{.value = 90}}};
  LookOptions maximum = surface;
  maximum.mode = LookOptions::Mode::kMaximum;
  const std::string refused =
      "surfaces needs mode composite, since other modes show one value a pixel";
  EXPECT_EQ(errorOf([&] { Renderer(volume, maximum); }), refused);
  Renderer renderer(volume, surface);
  const Image expected = renderer.draw(kSmall);
  EXPECT_EQ(errorOf([&] { renderer.setLook(maximum); }), refused);
  EXPECT_EQ(renderer.draw(kSmall).rgba, expected.rgba);
  PictureOptions shadowed = kSmall;
  shadowed.lighting.shadows = 0.5;
  maximum.surfaces.clear();
  renderer.setLook(maximum);
  EXPECT_EQ(errorOf([&] { renderer.draw(shadowed); }),
            "lighting.shadows needs mode composite, since other modes are not lit");
  renderer.setLook({.threshold = 90, .light = LookOptions::Light::kOff});
  EXPECT_EQ(errorOf([&] { renderer.draw(shadowed); }),
            "lighting.shadows lights the picture; leave out light");
  shadowed.lighting.shadows = 0;
  renderer.draw(shadowed);
  EXPECT_EQ(
      errorOf([&] { renderer.setLook({.mode = LookOptions::Mode::kAverage, .labels = true}); }),
      "labels needs mode composite, since other modes mix the numbers of labels");
}

TEST(Renderer, picturesThatAreNoneThrowAndTheNextIsRight) {
  const Volume volume(kShells);
  Renderer renderer(volume, {.threshold = 90});
  const Image expected = renderer.draw(kSmall);
  using Change = std::function<void(PictureOptions&)>;
  const std::vector<std::pair<std::string, Change>> wrong = {
      {"0 x 80", [](PictureOptions& p) { p.width = 0; }},
      {"-1", [](PictureOptions& p) { p.height = -1; }},
      {"pixels", [](PictureOptions& p) { p.width = 1 << 30; }},
      {"time 1", [](PictureOptions& p) { p.time = 1; }},
      {"time -1", [](PictureOptions& p) { p.time = -1; }},
      {"step", [](PictureOptions& p) { p.step_vox = 0; }},
      {"step", [](PictureOptions& p) { p.step_vox = kNan; }},
      {"step", [](PictureOptions& p) { p.step_vox = 1e-9; }},
      {"crop",
       [](PictureOptions& p) {
         p.crop = {{{0, 0, 0}, {0, 9, 9}}};
       }},
      {"crop",
       [](PictureOptions& p) {
         p.crop = {{{0, 0, 0}, {49, 9, 9}}};
       }},
      {"crop",
       [](PictureOptions& p) {
         p.crop = {{{INT64_MIN, 0, 0}, {INT64_MAX, 9, 9}}};
       }},
      {"zoom", [](PictureOptions& p) { p.view.zoom = 0; }},
      {"zoom", [](PictureOptions& p) { p.view.zoom = kNan; }},
      {"azimuth", [](PictureOptions& p) { p.view.azimuth_deg = kNan; }},
      {"elevation", [](PictureOptions& p) { p.view.elevation_deg = INFINITY; }},
      {"field of view", [](PictureOptions& p) { p.view.field_of_view_deg = 180; }},
      {"up",
       [](PictureOptions& p) {
         p.view.up = {{0, 0, 0}};
       }},
      {"up",
       [](PictureOptions& p) {
         p.view.up = {{0, kNan, 0}};
       }},
      {"eye",
       [](PictureOptions& p) {
         p.view.look_at = {{{1, 1, 1}, {1, 1, 1}}};
       }},
      {"finite",
       [](PictureOptions& p) {
         p.view.look_at = {{{kNan, 1, 1}, {1, 1, 1}}};
       }},
      {"reach",
       [](PictureOptions& p) {
         p.view.framing = {.target = {1, 1, 1}, .reach = 0};
       }},
      {"framing", [](PictureOptions& p) { p.view.framing = {.target = {}, .reach = kNan}; }},
      {"framing",
       [](PictureOptions& p) {
         p.view.framing = {.target = {kNan, 1, 1}};
       }},
      {"view.from", [](PictureOptions& p) { p.view.from = static_cast<ViewOptions::From>(99); }},
      {"view.fit", [](PictureOptions& p) { p.view.fit = static_cast<ViewOptions::Fit>(99); }}};
  for (const auto& [word, change] : wrong) {
    PictureOptions picture = kSmall;
    change(picture);
    EXPECT_THAT(errorOf([&] { renderer.draw(picture); }), HasSubstr(word)) << word;
    EXPECT_EQ(renderer.draw(kSmall).rgba, expected.rgba) << word;
  }
  PictureOptions deep = kSmall;
  deep.with_depth = true;
  renderer.setLook({.mode = LookOptions::Mode::kMaximum});
  EXPECT_THAT(errorOf([&] { renderer.draw(deep); }), HasSubstr("depth"));
}

TEST(Renderer, looksThatAreNoneThrowAndLeaveTheLookAsItWas) {
  const TempFolder folder;
  const auto broken = folder.write("broken.json", "{").string();
  const Volume volume(kShells);
  Renderer renderer(volume, {.threshold = 90});
  const Image expected = renderer.draw(kSmall);
  const std::string text = renderer.lookText();
  const std::vector<std::pair<std::string, LookOptions>> wrong = {
      {"threshold", {.threshold = kNan}},
      {"opacity", {.opacity = 2}},
      {"opacity", {.threshold = 3, .opacity = -1}},
      {"opacity", {.opacity = kNan}},
      {"rainbow", {.map = "rainbow"}},
      {"rainbow", {.threshold = 3, .map = "rainbow"}},
      {"range", {.range = {{1, 1}}}},
      {"range", {.range = {{kNan, 1}}}},
      {"full_gradient", {.full_gradient = 0}},
      {"full_gradient", {.full_gradient = INFINITY}},
      {broken, {.transfer_file = broken}},
      {"none.json", {.transfer_file = folder / "none.json"}},
      {"", {.opacities = {{5, 0.2}, {4, 0.1}}}},
      {"", {.opacities = {{5, 2}}}},
      {"", {.opacities = {{kNan, 0.2}}}},
      {"mode", {.mode = static_cast<LookOptions::Mode>(99)}}};
  for (const auto& [word, look] : wrong) {
    EXPECT_THAT(errorOf([&, &given = look] { renderer.setLook(given); }), HasSubstr(word)) << word;
    EXPECT_EQ(renderer.lookText(), text) << word;
    EXPECT_THAT(errorOf([&, &given = look] { Renderer other(volume, given); }), HasSubstr(word));
  }
  EXPECT_EQ(renderer.draw(kSmall).rgba, expected.rgba);
  EXPECT_TRUE(renderer.lookWarnings().empty());
  renderer.setLook({.threshold = 1e6});
  EXPECT_EQ(renderer.lookWarnings().size(), 1U);
  EXPECT_EQ(visiblePixels(renderer.draw(kSmall).toRgba8()), 0U);
}

// Whatever the values are: a picture or an Error.
TEST(Renderer, anyLookOfAnyValuesIsDrawnOrRefused) {
  const TempFolder folder;
  const auto floats = [&](const char* name, const std::function<float(int)>& value) {
    std::vector<float> voxels;
    for (int i = 0; i < 20 * 20 * 20; ++i) voxels.push_back(value(i));
    return folder
        .write(name, {reinterpret_cast<const char*>(voxels.data()), voxels.size() * sizeof(float)})
        .string();
  };
  constexpr float kMost = std::numeric_limits<float>::max();
  const std::vector<std::string> volumes = {
      floats("one_20x20x20_float32.raw", [](int) { return 7.0F; }),
      floats("nan_20x20x20_float32.raw", [](int) { return NAN; }),
      floats("infinite_20x20x20_float32.raw", [](int i) { return i % 3 == 0 ? INFINITY : 1.0F; }),
      floats("far_20x20x20_float32.raw", [](int i) { return i % 2 == 0 ? -kMost : kMost; }),
      floats("many_20x20x20_float32.raw", [](int i) { return std::sin(static_cast<float>(i)); }),
      folder.write("thin_2x2x100_uint8.raw", std::string(400, 'a')).string()};
  const std::vector<LookOptions> looks = {{},
                                          {.labels = true},
                                          {.threshold = 0},
                                          {.threshold = 1e300},
                                          {.threshold = -1e300, .range = {{-1e300, 1e300}}},
                                          {.opacities = {{-1e300, 0}, {1e300, 1}}},
                                          {.opacity = 1, .full_gradient = 1e-300},
                                          {.mode = LookOptions::Mode::kMinimum, .labels = true},
                                          {.mode = LookOptions::Mode::kAverage, .map = "hot"}};
  for (const std::string& name : volumes) {
    const Volume volume(name);
    Renderer renderer(volume);
    for (const LookOptions& look : looks) {
      SCOPED_TRACE(name);
      try {
        renderer.setLook(look);
        EXPECT_EQ(renderer.draw(kSmall).toRgba8().size(), 96U * 80U * 4U);
      } catch (const Error& error) {
        EXPECT_STRNE(error.what(), "");
      }
    }
  }
}

TEST(Renderer, tooLittleMemoryNamesTheLeast) {
  const Volume volume(kShells);
  EXPECT_THAT(errorOf([&] { Renderer renderer(volume, {}, {.memory_bytes = 1}); }),
              HasSubstr("memory"));
  EXPECT_THAT(errorOf([&] { Renderer renderer(volume, {}, {.threads = -2}); }),
              HasSubstr("threads"));
}

TEST(Renderer, aFileThatGoesAwayIsNamedAndTheRendererStaysUsable) {
  const TempFolder folder;
  const std::string name = "a_64x64x64_uint8.raw";
  std::string voxels;
  for (int i = 0; i < 64 * 64 * 64; ++i) voxels += static_cast<char>(i % 251);
  const auto path = folder.write(name, voxels);
  const Volume volume(path.string());
  Renderer renderer(volume, {.threshold = 100});
  std::filesystem::resize_file(path, 1000);
  EXPECT_THAT(errorOf([&] { renderer.draw(kSmall); }), HasSubstr(name));
  EXPECT_THAT(errorOf([&] { renderer.draw(kSmall); }), HasSubstr(name));
}

}  // namespace
}  // namespace sluice
