// Pictures with several rays a pixel are the same on every device and with every block size, as
// pictures with one ray are.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

constexpr const char* kGl = "--device gl --gl osmesa";

class KeepThin : public testing::Test {
 protected:
  KeepThin() {
    const CommandResult packed = program_.run(
        "pack synth:phantom,dims=112x104x96 -o parts.zarr --chunk 16 --levels 3 --downsample "
        "mean,max,min");
    EXPECT_EQ(packed.status, 0) << packed.output;
  }
  // The picture's channels, premultiplied. nullopt: the machine lacks the device.
  std::optional<std::vector<double>> drawn(const std::string& options) const {
    const CommandResult result =
        program_.run("render " + volume_ + " -o a.png --force -q --keep-thin " + options);
    if (result.output.find("has no such instructions") != std::string::npos ||
        (result.status != 0 && options.find("--device gl") != std::string::npos))
      return std::nullopt;
    EXPECT_EQ(result.status, 0) << result.output;
    const Rgba8Picture picture = readPng(program_.folder / "a.png");
    std::vector<double> channels(picture.rgba.begin(), picture.rgba.end());
    for (size_t i = 0; i < channels.size(); ++i)
      if (i % 4 != 3) channels[i] *= picture.rgba[i / 4 * 4 + 3] / 255.0;
    return channels;
  }
  // Compares the pictures of both lots of options by their greatest difference.
  void expectAlike(const std::string& options, const std::string& others, double most) const {
    SCOPED_TRACE(options + ": " + others);
    const auto picture = drawn(options), other = drawn(options + " " + others);
    ASSERT_TRUE(picture);
    EXPECT_GT(*std::ranges::max_element(*picture), 100);
    if (!other) return;
    ASSERT_EQ(picture->size(), other->size());
    double greatest = 0;
    for (size_t i = 0; i < picture->size(); ++i)
      greatest = std::max(greatest, std::abs((*picture)[i] - (*other)[i]));
    EXPECT_LE(greatest, most);
  }
  const Program program_;
  std::string volume_ = "parts.zarr";
};

// Most rays of a surface are opaque but for rounding, and differ in colour.
TEST_F(KeepThin, showsTheSameOfOpaqueRaysWhateverRoundsThem) {
  const std::string opaque = "--threshold 60 --opacity 1 --shade --size 61x53 ";
  for (const char* others : {"--simd plain", "--simd sse4", "--simd avx2",
                             "--algorithm conventional", "--page 8x8x8", kGl})
    expectAlike(opaque + "--block 16", others, 1.01);
}

// Rays touch the surface of noise everywhere, and each pixel keeps the brightest of many rays.
TEST_F(KeepThin, findsSurfacesOfNoiseWithAllInstructions) {
  constexpr int64_t kSide = 96;
  std::vector<char> voxels;
  for (int64_t i = 0; i < kSide * kSide * kSide; ++i) {
    uint32_t noise = static_cast<uint32_t>(i) * 2654435761U + 12345U;
    noise ^= noise >> 15;
    noise *= 2246822519U;
    noise ^= noise >> 13;
    const int64_t x = i % kSide - 47, y = i / kSide % kSide - 46, z = i / (kSide * kSide) - 48;
    const int64_t ball = std::max<int64_t>(0, 1600 - x * x - y * y - z * z) / 10;
    voxels.push_back(static_cast<char>(std::min<int64_t>(3 + ball - (noise >> 8 & 1), 255)));
  }
  std::ofstream(program_.folder / "noise.raw", std::ios::binary)
      .write(voxels.data(), static_cast<std::streamsize>(voxels.size()));
  const CommandResult packed =
      program_.run("pack noise.raw --dims 96,96,96 --type u8 -o noise.zarr --chunk 16 --levels 3");
  ASSERT_EQ(packed.status, 0) << packed.output;
  volume_ = "noise.zarr";
  for (const char* others : {"--simd sse4", "--simd plain"})
    expectAlike("--iso 3 --block 16 --size 121", others, 1.01);
}

// OpenGL looks for the pixels of a box in clip space, which is shifted together with the rays.
TEST_F(KeepThin, showsTheOutlineOfTheVolumeOnEveryDevice) {
  for (const char* mode : {"mip", "minip"})
    for (const char* projection : {"ortho", "perspective"})
      expectAlike(
          fmt::format("--mode {} --projection {} --size 61x53 --map grey", mode, projection), kGl,
          1.01);
}

}  // namespace
}  // namespace sluice
