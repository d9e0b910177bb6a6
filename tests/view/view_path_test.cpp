#include "src/view/state/view_path.h"

#include <gtest/gtest.h>
#include <sluice/renderer.h>
#include <sluice/volume.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/options/option_rules.h"
#include "src/options/option_table.h"
#include "src/view/state/editing/camera_gestures.h"

namespace sluice {
namespace {

ViewState lookingFrom(std::array<double, 3> eye, std::array<double, 3> up = {0, 1, 0}) {
  ViewState state;
  state.view.look_at = ViewOptions::LookAt{eye, {0, 0, 0}};
  state.view.up = up;
  return state;
}

ViewPath keysOf(const std::vector<ViewState>& states, double seconds = 2, double rate = 10) {
  ViewPath path;
  path.kind = ViewPath::Kind::kKeys;
  path.frames_per_second = rate;
  for (const ViewState& state : states) path.keys.push_back({state, seconds});
  return path;
}

double distanceOf(const ViewState& state) {
  const auto& at = *state.view.look_at;
  return std::hypot(at.eye[0] - at.target[0], at.eye[1] - at.target[1], at.eye[2] - at.target[2]);
}

TEST(ViewPath, aTurnIsAboutTheVerticalAndComesBack) {
  ViewPath path;
  path.turn_frames = 8;
  const ViewState now = lookingFrom({0, 0, 10});
  EXPECT_EQ(frameCount(path), 8);
  for (int64_t i = 0; i < 8; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / 8;
    const auto eye = stateAt(path, now, i).view.look_at->eye;
    EXPECT_NEAR(eye[0], 10 * std::sin(angle), 1e-12) << i;
    EXPECT_NEAR(eye[1], 0, 1e-12) << i;
    EXPECT_NEAR(eye[2], 10 * std::cos(angle), 1e-12) << i;
  }
  // A turn of a view that looks down at an angle keeps the distance and the up direction.
  const ViewState tilted = lookingFrom({0, 6, 8}, {0, 0.8, -0.6});
  for (int64_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(distanceOf(stateAt(path, tilted, i)), 10, 1e-12);
    EXPECT_NEAR((*stateAt(path, tilted, i).view.up)[1], 0.8, 1e-12);
  }
}

TEST(ViewPath, keyFramesAreFramesAndTheirNumberFollowsFromTheSeconds) {
  EXPECT_EQ(frameCount(keysOf({})), 0);
  EXPECT_EQ(frameCount(keysOf({lookingFrom({0, 0, 5})})), 1);
  std::vector<ViewState> states{lookingFrom({0, 0, 5}), lookingFrom({5, 0, 0}),
                                lookingFrom({0, 3, 4}, {0, 0.8, -0.6})};
  states[1].look.threshold = 40;
  const ViewPath path = keysOf(states);
  EXPECT_EQ(frameCount(path), 41);
  EXPECT_DOUBLE_EQ(secondsOf(path), 4);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(stateAt(path, {}, static_cast<int64_t>(i) * 20), states[i]) << i;
  // A frame's length that does not divide the seconds: 0.1 * 3 is no sum of tenths.
  EXPECT_EQ(frameCount(keysOf({states[0], states[1]}, 0.3, 10)), 4);
}

TEST(ViewPath, theEyeGoesRoundAndNotThrough) {
  const ViewPath path = keysOf({lookingFrom({0, 0, 10}), lookingFrom({10, 0, 0})});
  for (int64_t i = 0; i < frameCount(path); ++i) {
    const ViewState state = stateAt(path, {}, i);
    EXPECT_NEAR(distanceOf(state), 10, 1e-9) << i;
    EXPECT_NEAR(state.view.look_at->eye[1], 0, 1e-9) << i;
  }
  // Half of the time is half of the way: 45 degrees.
  const auto eye = stateAt(path, {}, 10).view.look_at->eye;
  EXPECT_NEAR(eye[0], eye[2], 1e-9);
  // From front to back too, and from any direction to any other.
  for (const std::array<double, 3>& to :
       {std::array{0.0, 0.0, -10.0}, {-6.0, 0.0, 8.0}, {0.0, 0.0, 10.0}}) {
    const ViewPath half = keysOf({lookingFrom({0, 0, 10}), lookingFrom(to)});
    for (int64_t i = 0; i < frameCount(half); ++i)
      EXPECT_NEAR(distanceOf(stateAt(half, {}, i)), 10, 1e-9);
  }
}

TEST(ViewPath, everyTurningComesThrough) {
  // Axes of all octants: the quaternion of each is another one's largest part.
  for (const std::array<double, 3>& eye : {std::array{0.0, 0.0, 3.0},
                                           {0.0, 0.0, -3.0},
                                           {3.0, 0.0, 0.0},
                                           {-3.0, 0.0, 0.0},
                                           {0.0, 3.0, 0.0},
                                           {0.0, -3.0, 0.0},
                                           {1.0, -2.0, 2.0},
                                           {-2.0, 1.0, -2.0}}) {
    std::array<double, 3> up{0, 1, 0};
    if (eye[0] == 0 && eye[2] == 0) up = {1, 0, 0};
    const ViewState state = lookingFrom(eye, up);
    ViewState other = state;
    other.view.zoom = 4;
    // Nothing but the zoom goes from one to the other.
    const ViewState between = stateAt(keysOf({state, other}), {}, 10);
    const PlacedAxes wanted = axesOf(state.view), found = axesOf(between.view);
    EXPECT_NEAR(dot(wanted.up, found.up), 1, 1e-9) << eye[0] << eye[1] << eye[2];
    EXPECT_NEAR(dot(wanted.back, found.back), 1, 1e-9);
    EXPECT_NEAR(between.view.zoom, 2, 1e-9);  // zoom is interpolated as a logarithm
  }
}

TEST(ViewPath, numbersOfTheLookAndCutsGoSmoothlyAndNeverBeyondTheirKeys) {
  std::vector<ViewState> states(4, lookingFrom({0, 0, 5}));
  const std::array<double, 4> thresholds{10, 60, 60, 20};
  for (size_t i = 0; i < 4; ++i) {
    states[i].look.threshold = thresholds[i];
    states[i].look.range = std::array{0.0, 100 + 10.0 * static_cast<double>(i)};
    states[i].crop = PictureOptions::Box{{static_cast<int64_t>(i), 0, 0}, {40, 40, 40}};
    states[i].step_vox = 1;
    states[i].time = static_cast<int64_t>(2 * i);
  }
  const ViewPath path = keysOf(states, 1, 100);
  double last = 10, last_step = 0;
  for (int64_t i = 0; i < frameCount(path); ++i) {
    const ViewState state = stateAt(path, {}, i);
    const double threshold = *state.look.threshold;
    EXPECT_GE(threshold, 10);
    EXPECT_LE(threshold, 60);
    // No jump, and no kink: a step differs little from the one before it.
    EXPECT_LT(std::abs(threshold - last), 1.6) << i;
    if (i > 1) {
      EXPECT_LT(std::abs(threshold - last - last_step), 0.1) << i;
    }
    last_step = threshold - last;
    last = threshold;
    EXPECT_EQ(state.crop->hi[0], 40);
    EXPECT_EQ(*state.step_vox, 1);
    EXPECT_GE(state.time, i / 100 * 2);
  }
  EXPECT_EQ(stateAt(path, {}, 150).look.threshold, 60);
}

// Two values of an option that differ in their numbers alone, the later ones greater; nullopt: the
// option is no number.
std::optional<std::pair<OptionValue, OptionValue>> twoValues(const OptionKind& kind) {
  const NumberRange<double>& limits = kind.limits;
  const double low = std::max(limits.least, 0.0) + 0.125, high = std::min(limits.most, 8.0) - 0.125;
  switch (kind.form) {
    case OptionForm::kWhole:
    case OptionForm::kBytes:
      return std::pair(int64_t{2}, int64_t{40});
    case OptionForm::kNumber:
    case OptionForm::kSeconds:
      return std::pair(low, high);
    case OptionForm::kRange:
    case OptionForm::kAngles:
      return std::pair(OptionReals{low, high}, OptionReals{high, low + 40});
    case OptionForm::kColor:
      return std::pair(OptionReals{0, 0.25, 0.5}, OptionReals{0.5, 0.75, 1});
    case OptionForm::kBox:
      return std::pair(OptionWholes{0, 1, 2, 9, 9, 9}, OptionWholes{9, 10, 11, 90, 91, 92});
    case OptionForm::kPoints:
      return std::pair(std::vector<OptionReals>{{1, 0.25}, {2, 0.5}},
                       std::vector<OptionReals>{{10, 0.5}, {20, 1}});
    case OptionForm::kPlanes:
      return std::pair(std::vector<OptionReals>{{0, 0, 1, 4}},
                       std::vector<OptionReals>{{1, 1, 2, 40}});
    case OptionForm::kSurfaces:
      return std::pair(std::vector<std::string>{"10:0.25:red", "30"},
                       std::vector<std::string>{"20:0.75:blue", "90:0.5"});
    case OptionForm::kLabels:
      return std::pair(std::vector<std::string>{"3=ff8800:0.25", "7-9=:0"},
                       std::vector<std::string>{"3=ff8800:0.75", "7-9=:1"});
    case OptionForm::kChannels:
      return std::pair(std::vector<std::string>{"0:green,400:3000,0.25"},
                       std::vector<std::string>{"0:green,600:4000,0.75"});
    default:
      return std::nullopt;
  }
}

// The first number that changes between two values.
double firstOf(bool /*flag*/) {
  return 0;
}
double firstOf(double number) {
  return number;
}
double firstOf(int64_t number) {
  return static_cast<double>(number);
}
double firstOf(const std::string& text) {
  size_t at = text.find_first_of(",=");  // of a channel's range, or a label's opacity
  if (at != std::string::npos && text[at] == '=') at = text.find(':', at);
  return std::stod(at == std::string::npos ? text : text.substr(at + 1));
}
template <class Item>
double firstOf(const std::vector<Item>& list) {
  return firstOf(list.front());
}

// A number is known by the form of its option alone: no list of names tells which of them change.
TEST(ViewPath, everyNumberOfTheTableGoesFromKeyToKey) {
  const auto first = [](const OptionValue& value) {
    return std::visit([](const auto& held) { return firstOf(held); }, value);
  };
  int changed = 0;
  for (const OptionEntry& entry : optionTable()) {
    if (entry.part == OptionPart::kCamera || entry.option.empty()) continue;
    const auto values = twoValues(entry.kind);
    if (!values) continue;
    SCOPED_TRACE(entry.option);
    ViewState from = lookingFrom({0, 0, 5}), to = from;
    entry.set(from, values->first);
    entry.set(to, values->second);
    const ViewPath path = keysOf({from, to});
    double last = first(*entry.get(from));
    for (const int64_t frame : {5, 10, 15, 20}) {
      const double number = first(*entry.get(stateAt(path, {}, frame)));
      EXPECT_GT(number, last) << frame;
      last = number;
    }
    ++changed;
  }
  EXPECT_GT(changed, 25);
}

TEST(ViewPath, surfacesLabelsAndChannelsChangeTheirNumbersAlone) {
  ViewState a = lookingFrom({0, 0, 5}), b = a;
  a.look.surfaces = {{10, 1, "red"}, {30, 0.5, ""}};
  b.look.surfaces = {{20, 0.5, "blue"}, {30, 0.5, ""}};
  a.look.label_looks = {{3, 3, "red", 0.2}, {4, 4, "red", {}}};
  b.look.label_looks = {{3, 3, "red", 0.4}, {4, 4, "red", 0.8}};
  a.look.channels = {{"0", "green", std::array{0.0, 10.0}, 0.2}, {"1", "red", {}, {}}};
  b.look.channels = {{"0", "green", std::array{20.0, 30.0}, {}}, {"1", "red", {}, 0.5}};
  const LookOptions look = stateAt(keysOf({a, b}), {}, 10).look;
  EXPECT_EQ(look.surfaces, (std::vector<LookOptions::Surface>{{15, 0.75, "red"}, {30, 0.5, ""}}));
  ASSERT_EQ(look.label_looks.size(), 2U);
  EXPECT_NEAR(*look.label_looks[0].opacity, 0.3, 1e-12);
  EXPECT_EQ(look.label_looks[1], a.look.label_looks[1]);
  EXPECT_EQ(look.channels, (std::vector<LookOptions::Channel>{
                               {"0", "green", std::array{10.0, 20.0}, 0.2}, {"1", "red", {}, {}}}));
  // Other labels and channels are others, whatever their numbers.
  b.look.label_looks[0].first = 2;
  b.look.channels[0].channel = "2";
  const LookOptions earlier = stateAt(keysOf({a, b}), {}, 10).look;
  EXPECT_EQ(earlier.label_looks, a.look.label_looks);
  EXPECT_EQ(earlier.channels, a.look.channels);
}

// The lower end moves fast between these keys before the upper one begins to.
TEST(ViewPath, boxesStayAVoxelWide) {
  std::vector<ViewState> states(3, lookingFrom({0, 0, 5}));
  states[0].crop = PictureOptions::Box{{0, 0, 0}, {102, 9, 9}};
  states[1].crop = PictureOptions::Box{{100, 0, 0}, {102, 9, 9}};
  states[2].crop = PictureOptions::Box{{200, 0, 0}, {202, 9, 9}};
  const ViewPath path = keysOf(states);
  for (int64_t i = 0; i < frameCount(path); ++i) {
    const PictureOptions::Box box = *stateAt(path, {}, i).crop;
    EXPECT_GE(box.hi[0], box.lo[0] + 1) << i;
    EXPECT_LE(box.hi[0], 202) << i;
  }
}

TEST(ViewPath, whatHasNoNumbersIsTheEarlierKeys) {
  ViewState a = lookingFrom({0, 0, 5}), b = a;
  a.look.threshold = 10;
  a.look.map = "viridis";
  b.look.opacities = {{0, 0}, {9, 1}};
  b.look.mode = LookOptions::Mode::kMaximum;
  b.background = std::array{1.0F, 1.0F, 1.0F};
  const ViewPath path = keysOf({a, b});
  const ViewState between = stateAt(path, {}, 19);
  EXPECT_EQ(between.look, a.look);
  EXPECT_FALSE(between.background);
  EXPECT_EQ(stateAt(path, {}, 20).look, b.look);
  // Points of the same number move, and stay in order.
  ViewState c = b;
  c.look.opacities = {{6, 0.5}, {7, 0}};
  for (int64_t i = 0; i <= 20; ++i) {
    const auto points = stateAt(keysOf({b, c}), {}, i).look.opacities;
    ASSERT_EQ(points.size(), 2U);
    EXPECT_LE(points[0].value, points[1].value);
  }
}

TEST(ViewPath, whatIsNoPartOfAFilmStays) {
  ViewState now;
  now.shows_slices = true;
  now.cross = {4, 5, 6};
  const ViewPath path = keysOf({lookingFrom({0, 0, 5}), lookingFrom({0, 0, 9})});
  for (const int64_t frame : {0, 7, 20}) {
    EXPECT_TRUE(stateAt(path, now, frame).shows_slices);
    EXPECT_EQ(stateAt(path, now, frame).cross, now.cross);
  }
}

TEST(ViewPath, namesItsFileBesideTheFrames) {
  EXPECT_EQ(pathFileFor("frame_%04d.png"), "frame.json");
  EXPECT_EQ(pathFileFor("out dir/turn-####.exr"), "out dir/turn.json");
  EXPECT_EQ(pathFileFor("/a/%d.png"), "/a/path.json");
}

TEST(ViewPath, numbersOfOneKeyAloneStartFromTheirDefaults) {
  ViewState first = lookingFrom({0, 0, 10}), second = first;
  second.lighting.shadows = 1;
  second.lighting.key = {{22, 29}};
  const ViewPath there = keysOf({first, second}), back = keysOf({second, first});
  const ViewState middle = stateAt(there, first, 10);
  EXPECT_NEAR(middle.lighting.shadows.value(), 0.5, 1e-12);
  EXPECT_NEAR(middle.lighting.key.value()[0], 0, 1e-12);
  EXPECT_FALSE(middle.lighting.ambient.has_value()) << "set by neither";
  EXPECT_NEAR(stateAt(back, first, 10).lighting.shadows.value(), 0.5, 1e-12);
  EXPECT_FALSE(stateAt(back, first, 20).lighting.shadows.has_value());
}

// A film that goes on from such a value begins with the picture of the key that does not set it.
TEST(ViewPath, defaultsOfTheTableDrawThePictureWithoutThem) {
  const Volume volume("synth:shells,dims=64x64x64");  // large enough for light around a place
  size_t known = 0;
  for (const OptionEntry& entry : optionTable()) {
    if (!entry.unset) continue;
    ++known;
    ViewState state;
    state.look.threshold = 60;
    state.look.opacity = 1;
    if (entry.option == "--attenuation") {
      state.look.mode = LookOptions::Mode::kAttenuatedMaximum;
      state.look.threshold.reset();
      state.look.opacity.reset();
    } else {
      state.look.light = LookOptions::Light::kOn;
    }
    const auto drawn = [&] {
      return Renderer(volume, lookOf(state), {.device = RendererOptions::Device::kCpu})
          .draw(pictureOf(state, 64, 48))
          .toRgba8(std::array{0.0F, 0.0F, 0.0F});
    };
    const std::vector<uint8_t> without = drawn();
    const auto difference = [&] {
      const std::vector<uint8_t> found = drawn();
      int largest = 0;
      for (size_t i = 0; i < found.size(); ++i)
        largest = std::max(largest, std::abs(found[i] - without[i]));
      return largest;
    };
    entry.set(state, *entry.unset);
    EXPECT_LE(difference(), 1) << entry.option;  // the direction of the light is rounded
    OptionValue other = *entry.unset;
    if (double* number = std::get_if<double>(&other)) *number = *number == 0 ? 1 : *number + 0.3;
    if (auto* numbers = std::get_if<OptionReals>(&other)) (*numbers)[0] += 40;
    entry.set(state, other);
    EXPECT_GT(difference(), 1) << entry.option;
  }
  EXPECT_EQ(known, 9U);
}

TEST(ViewPath, namesTheNumbersThatJump) {
  ViewState first = lookingFrom({0, 0, 10}), second = lookingFrom({10, 0, 0});
  first.lighting.shadows = 0.5;  // the other key has its default
  first.look.threshold = 40;
  second.look.threshold = 50;
  first.look.map = "viridis";
  second.view.zoom = 2;
  EXPECT_EQ(jumpsAlong(keysOf({first, second, first})), std::nullopt);
  second.crop = {{0, 0, 0}, {8, 8, 8}};
  second.look.surfaces = {{.value = 20}};
  second.look.threshold.reset();
  const std::optional<std::string> jumps = jumpsAlong(keysOf({first, second}));
  ASSERT_TRUE(jumps.has_value());
  EXPECT_EQ(*jumps,
            "/look/threshold, /look/surfaces, /crop: set in some key frames only, or in different "
            "forms, so that the film jumps there");
  ViewPath turn = keysOf({first, second});
  turn.kind = ViewPath::Kind::kTurn;
  EXPECT_EQ(jumpsAlong(turn), std::nullopt);
}

}  // namespace
}  // namespace sluice
