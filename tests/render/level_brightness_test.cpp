// Where levels of resolution meet, the picture keeps its brightness: cuts of several levels against
// the finest level, window by window.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/render/level_scene.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

using LevelBrightness = LevelCutTest;

constexpr int64_t kSignalSide = 128;

// A function of the place in the volume, each coordinate -1..1, with values 0..255.
struct Signal {
  std::string name;
  std::function<double(Vec3d)> value;
  std::vector<std::pair<double, double>> opacities;
  bool lit = false;
};

double blob(Vec3d at, Vec3d middle, double width) {
  return std::exp(-dot(at - middle, at - middle) / (width * width));
}

std::vector<Signal> signals() {
  const auto ramp = [](Vec3d p) { return 255 * (0.5 + (0.5 * p.x + 0.3 * p.y + 0.2 * p.z) / 2); };
  const auto marschnerLobb = [](Vec3d p) {
    constexpr double kPi = 3.14159265358979, kFrequency = 6, kAlpha = 0.25;
    const double r = std::sqrt(p.x * p.x + p.y * p.y);
    const double ripple = std::cos(2 * kPi * kFrequency * std::cos(kPi * r / 2));
    return 255 * (1 - std::sin(kPi * p.z / 2) + kAlpha * (1 + ripple)) / (2 * (1 + kAlpha));
  };
  // Gentle hills with an edge of two voxels; a steep hill's outline would lie within the picture.
  const auto surface = [](Vec3d p) {
    const double height = -0.2 + 0.2 * std::sin(2.5 * p.x + 1) * std::cos(2 * p.y);
    return 255 * std::clamp(0.5 + (height - p.z) * kSignalSide / 4, 0.0, 1.0);
  };
  const auto fog = [](Vec3d p) {
    return 120 * blob(p, {-0.2, 0.1, 0.3}, 0.8) + 60 * blob(p, {0.5, -0.3, -0.4}, 0.4);
  };
  // Voxels without any order, whose light comes from slopes that coarser voxels do not have.
  const auto texture = [](Vec3d p) {
    uint32_t state = 1;
    for (int a = 0; a < 3; ++a) {
      state = (state + static_cast<uint32_t>(std::lround((p[a] + 1) * kSignalSide))) * 2654435761U;
      state ^= state >> 15;
    }
    return 28.0 + (state >> 8) % 200;
  };
  return {{"ramp", ramp, {{0, 0.005}, {255, 0.03}}},
          {"marschner-lobb", marschnerLobb, {{0, 0}, {90, 0.004}, {255, 0.05}}},
          {"surface", surface, {{100, 0}, {140, 0.6}, {255, 0.6}}},
          {"lit surface", surface, {{100, 0}, {140, 0.6}, {255, 0.6}}, true},
          {"lit texture", texture, {{0, 0.02}, {255, 0.05}}, true},
          {"fog", fog, {{0, 0}, {255, 0.02}}}};
}

constexpr int kWindow = 8, kMargin = 4;  // pixels

struct Window {
  std::array<double, 2> means{};  // of the colour channels and of the opacity
  // The least opacity in the window and a margin around it, which is small on an outline.
  double least_opacity = 1;
};

std::vector<Window> windowsOf(const FloatPicture& picture) {
  std::vector<Window> windows;
  for (int top = kMargin; top + kWindow + kMargin <= picture.height; top += kWindow)
    for (int left = kMargin; left + kWindow + kMargin <= picture.width; left += kWindow) {
      Window window;
      for (int y = top - kMargin; y < top + kWindow + kMargin; ++y)
        for (int x = left - kMargin; x < left + kWindow + kMargin; ++x) {
          const auto [r, g, b, a] = picture.at(x, y);
          window.least_opacity = std::min<double>(window.least_opacity, a);
          if (y < top || y >= top + kWindow || x < left || x >= left + kWindow) continue;
          window.means[0] += static_cast<double>(r + g + b) / (3 * kWindow * kWindow);
          window.means[1] += static_cast<double>(a) / (kWindow * kWindow);
        }
      windows.push_back(window);
    }
  return windows;
}

TEST_F(LevelBrightness, staysWithinFivePercentWhereLevelsMeet) {
  for (const Signal& signal : signals()) {
    FunctionSource source(
        functionLayout({kSignalSide, kSignalSide, kSignalSide}, VoxelType::kU8),
        [&](int64_t, Vec3i v) {
          const Vec3d at = toDouble(v) * (2.0 / (kSignalSide - 1)) - Vec3d{1, 1, 1};
          return std::clamp(std::round(signal.value(at)), 0.0, 255.0);
        });
    Pyramid pyramid(source, 3, signal.lit, Spreads::kKept);
    TransferFunction transfer;
    transfer.colors = {{0, {0.2, 0.4, 1}}, {255, {1, 0.8, 0.3}}};
    for (const auto& [value, opacity] : signal.opacities)
      transfer.opacities.push_back({value, opacity});
    const auto session = sessionOf(pyramid, transfer, signal.lit);
    std::vector<FrameOptions> views{obliqueView(Projection::kOrtho),
                                    insideView(source.layout(), {0.05, 0.1, 0.95}, {0.8, 0.7, 0.2}),
                                    insideView(source.layout(), {0.1, 0.5, 0.6}, {1, 0.45, 0.4})};
    views[0].cut = CutOptions{.pixel_error = 0.01, .most_stored_bytes = 1'000'000};
    views[1].cut = CutOptions{.pixel_error = 2};
    views[2].cut = CutOptions{.pixel_error = 3};
    for (FrameOptions& options : views) {
      SCOPED_TRACE(signal.name + " view " + std::to_string(&options - views.data()));
      options.step_vox = 0.5;
      // The outermost voxels of a level are drawn as far as the volume goes.
      options.crop = Box3{{4, 4, 4}, {kSignalSide - 5, kSignalSide - 5, kSignalSide - 5}};
      const Drawn cut = draw(*session, options);
      EXPECT_GT(cut.report.cut->levels.size(), 1U);
      options.cut.reset();
      const Drawn finest = draw(*session, options);
      const auto found = windowsOf(cut.picture), expected = windowsOf(finest.picture);
      double worst = 0, sum = 0, difference = 0;
      size_t compared = 0;
      for (size_t i = 0; i < expected.size(); ++i) {
        sum += expected[i].means[1];
        difference += found[i].means[1] - expected[i].means[1];
        if (expected[i].least_opacity < std::max(0.1, 0.5 * expected[i].means[1])) continue;
        for (size_t c = 0; c < 2; ++c)
          worst = std::max(worst, std::abs(found[i].means[c] / expected[i].means[c] - 1));
        ++compared;
      }
      EXPECT_GT(compared, 10U);
      EXPECT_LT(worst, 0.05);
      EXPECT_LT(std::abs(difference) / sum, 0.03) << "mean opacity";
    }
  }
}

}  // namespace
}  // namespace sluice
