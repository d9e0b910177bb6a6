// Volumes without a file: the pictures equal those of the same voxels in a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <stdexcept>

#include "tests/library/library_support.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr std::array<int64_t, 3> kDims{40, 30, 20};

// A ball, x fastest.
template <class T>
std::vector<T> ballVoxels(const std::array<int64_t, 3>& dims = kDims) {
  std::vector<T> voxels;
  for (int64_t z = 0; z < dims[2]; ++z)
    for (int64_t y = 0; y < dims[1]; ++y)
      for (int64_t x = 0; x < dims[0]; ++x) {
        const double dx = static_cast<double>(x) - 18, dy = static_cast<double>(y) - 13;
        const double dz = static_cast<double>(z) - 9;
        voxels.push_back(static_cast<T>(100 - std::min(100.0, dx * dx + dy * dy + 2 * dz * dz)));
      }
  return voxels;
}

template <class T>
Volume fileOf(const TempFolder& folder, const std::vector<T>& voxels, const std::string& type) {
  const std::string bytes(reinterpret_cast<const char*>(voxels.data()), voxels.size() * sizeof(T));
  return Volume(folder.write("ball.raw", bytes).string(), {.dims = kDims, .type = type});
}

std::vector<uint8_t> pictureOf(const Volume& volume) {
  Renderer renderer(volume, {.threshold = 20}, {.device = RendererOptions::Device::kCpu});
  return renderer.draw({.width = 96, .height = 80, .view = {.azimuth_deg = 30}}).toRgba8();
}

template <class T>
void expectThePictureOfAFile(const std::string& type) {
  SCOPED_TRACE(type);
  const TempFolder folder;
  const std::vector<T> voxels = ballVoxels<T>();
  const std::vector<uint8_t> expected = pictureOf(fileOf(folder, voxels, type));
  EXPECT_GT(visiblePixels(expected), 500U);
  const ArrayLayout layout{.dims = kDims, .type = type};
  EXPECT_EQ(pictureOf(Volume::borrow(voxels.data(), layout)), expected);
}

TEST(Array, ofAnyTypeGivesThePictureOfAFile) {
  expectThePictureOfAFile<uint8_t>("u8");
  expectThePictureOfAFile<int16_t>("i16");
  expectThePictureOfAFile<uint32_t>("u32");
  expectThePictureOfAFile<float>("f32");
  expectThePictureOfAFile<double>("f64");
}

// Every order of the axes, each of them forwards or backwards, with room between the voxels.
TEST(Array, ofAnyStridesGivesThePictureOfAFile) {
  const TempFolder folder;
  const std::vector<uint16_t> packed = ballVoxels<uint16_t>();
  const std::vector<uint8_t> expected = pictureOf(fileOf(folder, packed, "u16"));
  const ArrayLayout layout{.dims = kDims, .type = "u16"};
  std::array<size_t, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      ArrayStrides strides{};
      int64_t words = 2, first = 0;
      for (const size_t axis : order) {
        strides[axis] = words;
        words = words * kDims[axis] + 3;
        if ((signs >> axis & 1) != 0) {
          first += strides[axis] * (kDims[axis] - 1);
          strides[axis] = -strides[axis];
        }
      }
      std::vector<uint16_t> room(static_cast<size_t>(words), 0);
      size_t at = 0;
      for (int64_t z = 0; z < kDims[2]; ++z)
        for (int64_t y = 0; y < kDims[1]; ++y)
          for (int64_t x = 0; x < kDims[0]; ++x)
            room[static_cast<size_t>(first + x * strides[0] + y * strides[1] + z * strides[2])] =
                packed[at++];
      for (int64_t& stride : strides) stride *= static_cast<int64_t>(sizeof(uint16_t));
      const Volume volume = Volume::borrow(room.data() + first, layout, strides);
      ASSERT_EQ(pictureOf(volume), expected) << signs;
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Array, hasThePlaceAndTheStepsThatAreGiven) {
  const std::vector<uint8_t> voxels(4 * 3 * 2 * 5, 7);
  const Volume volume = Volume::borrow(voxels.data(), {.dims = {4, 3, 2},
                                                       .type = "u8",
                                                       .time_steps = 5,
                                                       .spacing = {1, 2, 3},
                                                       .origin = {10, 20, 30},
                                                       .axes = {{{0, 2, 0}, {-1, 0, 0}, {0, 0, 1}}},
                                                       .unit = "millimeter",
                                                       .name = "density"});
  const VolumeInfo& info = volume.info();
  EXPECT_EQ(info.name, "density");
  EXPECT_EQ(info.dims, (std::array<int64_t, 3>{4, 3, 2}));
  EXPECT_EQ(info.time_steps, 5);
  EXPECT_EQ(info.spacing, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(info.origin, (std::array<double, 3>{10, 20, 30}));
  EXPECT_EQ(info.axes[0], (std::array<double, 3>{0, 1, 0}));
  EXPECT_EQ(info.axes[1], (std::array<double, 3>{-1, 0, 0}));
  EXPECT_EQ(info.unit, "millimeter");
  EXPECT_EQ(info.value_range, (std::array<double, 2>{7, 7}));
  EXPECT_TRUE(info.files.empty());
}

// A later step, which a stride of its own leads to.
TEST(Array, ofSeveralStepsShowsEach) {
  std::vector<uint8_t> steps(static_cast<size_t>(kDims[0] * kDims[1] * kDims[2]), 0);
  const std::vector<uint8_t> ball = ballVoxels<uint8_t>();
  steps.insert(steps.end(), ball.begin(), ball.end());
  const Volume volume =
      Volume::borrow(steps.data(), {.dims = kDims, .type = "u8", .time_steps = 2});
  Renderer renderer(volume, {.threshold = 20}, {.device = RendererOptions::Device::kCpu});
  EXPECT_EQ(visiblePixels(renderer.draw({.width = 64, .height = 64, .time = 0}).toRgba8()), 0U);
  EXPECT_GT(visiblePixels(renderer.draw({.width = 64, .height = 64, .time = 1}).toRgba8()), 200U);
}

TEST(Array, ofAFunctionGivesThePictureOfAFile) {
  const TempFolder folder;
  const std::vector<uint8_t> voxels = ballVoxels<uint8_t>();
  std::atomic<int> calls = 0;
  const FillBox fill = [&](int64_t time, const std::array<int64_t, 3>& lo,
                           const std::array<int64_t, 3>& hi, std::span<std::byte> out) {
    ++calls;
    EXPECT_EQ(time, 0);
    size_t at = 0;
    for (int64_t z = lo[2]; z < hi[2]; ++z)
      for (int64_t y = lo[1]; y < hi[1]; ++y)
        for (int64_t x = lo[0]; x < hi[0]; ++x)
          out[at++] = std::byte{voxels[static_cast<size_t>((z * kDims[1] + y) * kDims[0] + x)]};
    EXPECT_EQ(at, out.size());
  };
  const Volume volume = Volume::fromFunction(fill, {.dims = kDims, .type = "u8"});
  EXPECT_EQ(pictureOf(volume), pictureOf(fileOf(folder, voxels, "u8")));
  EXPECT_GT(calls, 0);
}

TEST(Array, whatItsFunctionThrowsEndsTheCall) {
  const FillBox fill = [](int64_t, const std::array<int64_t, 3>&, const std::array<int64_t, 3>&,
                          std::span<std::byte>) { throw std::runtime_error("no such voxels"); };
  EXPECT_THROW(Volume::fromFunction(fill, {.dims = kDims, .type = "u8"}), std::runtime_error);
}

// Level 2 holds stand-ins for NaN and infinities, which nobody must see.
TEST(Array, slicesHaveItsNansAndInfinities) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<float> voxels(3 * 3 * 3, 1);
  voxels[9 + 4] = kNan;
  voxels[9 + 5] = kInf;
  voxels[9 + 3] = -kInf;
  const Volume volume = Volume::borrow(voxels.data(), {.dims = {3, 3, 3}, .type = "f32"});
  Renderer renderer(volume, {}, {.device = RendererOptions::Device::kCpu});
  const SliceValues slice = renderer.slice({.axis = 2, .at = 1});
  ASSERT_EQ(slice.values.size(), 9U);
  EXPECT_TRUE(std::isnan(slice.values[4]));
  EXPECT_EQ(slice.values[5], kInf);
  EXPECT_EQ(slice.values[3], -kInf);
  for (const size_t i : {0, 1, 2, 6, 7, 8}) EXPECT_EQ(slice.values[i], 1);
}

// A sample with any part of a NaN shows nothing, in no mode.
TEST(Array, probesPassByPlacesBesideANan) {
  constexpr int64_t kSide = 12;
  const auto at = [](int64_t x, int64_t y, int64_t z) {
    return static_cast<size_t>((z * kSide + y) * kSide + x);
  };
  std::vector<float> voxels(kSide * kSide * kSide, 0);
  for (size_t i = 0; i < voxels.size(); ++i) voxels[i] = 1 + 0.001F * static_cast<float>(i % 7);
  for (int64_t y = 4; y < 8; ++y)
    for (int64_t x = 4; x < 8; ++x)
      for (int64_t z = 3; z < 9; ++z) voxels[at(x, y, z)] = kNan;
  const Volume volume =
      Volume::borrow(voxels.data(), {.dims = {kSide, kSide, kSide}, .type = "f32"});
  using Mode = LookOptions::Mode;
  for (const Mode mode : {Mode::kComposite, Mode::kMaximum, Mode::kMinimum, Mode::kAverage,
                          Mode::kAttenuatedMaximum}) {
    LookOptions look{.mode = mode};
    if (mode == Mode::kComposite) {
      look.threshold = 0.5;
      look.opacity = 0.5;
    }
    Renderer renderer(volume, look, {.device = RendererOptions::Device::kCpu});
    for (const double azimuth : {0.0, 33.0})
      for (const double right : {0.4, 0.5, 0.55}) {
        const auto found = renderer.probe(
            {.width = 64, .height = 64, .view = {.azimuth_deg = azimuth}}, right, 0.5);
        ASSERT_TRUE(found);
        EXPECT_GE(found->value, 0.99) << static_cast<int>(mode) << " at " << right;
        EXPECT_LE(found->value, 1.01) << static_cast<int>(mode) << " at " << right;
      }
  }
}

TEST(Array, probesBesideAnInfinityAreInfinite) {
  std::vector<float> voxels(8 * 8 * 8, 1);
  for (size_t i = 0; i < 8 * 8; ++i) voxels[3 * 8 * 8 + i] = std::numeric_limits<float>::infinity();
  const Volume volume = Volume::borrow(voxels.data(), {.dims = {8, 8, 8}, .type = "f32"});
  Renderer renderer(volume, {.mode = LookOptions::Mode::kMaximum},
                    {.device = RendererOptions::Device::kCpu});
  const auto found = renderer.probe({.width = 64, .height = 64}, 0.5, 0.5);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->value, std::numeric_limits<double>::infinity());
}

TEST(Array, thatIsNoneThrows) {
  const std::vector<uint8_t> voxels(64, 0);
  const auto line = [&](const void* first, const ArrayLayout& layout) {
    return errorOf([&] { Volume::borrow(first, layout); });
  };
  EXPECT_THAT(line(nullptr, {.dims = {4, 4, 4}, .type = "u8"}), HasSubstr("array: "));
  for (const auto& [layout, said] : std::vector<std::pair<ArrayLayout, std::string>>{
           {{.dims = {4, 0, 4}, .type = "u8", .name = "a"}, "4 x 0 x 4"},
           {{.dims = {INT64_MAX, 4, 4}, .type = "u8", .name = "a"}, "2^59"},
           {{.dims = {4, 4, 4}, .type = "u9", .name = "a"}, "u9"},
           {{.dims = {4, 4, 4}, .type = "u8", .time_steps = 0, .name = "a"}, "0 steps"},
           {{.dims = {4, 4, 4}, .type = "u8", .spacing = {1, -1, 1}, .name = "a"}, "spacing"},
           {{.dims = {4, 4, 4}, .type = "u8", .origin = {kNan, 0, 0}, .name = "a"}, "origin"},
           {{.dims = {4, 4, 4},
           .type = "u8",
           .axes = {{{1, 0, 0}, {0, 1, 0}, {1, 1, 0}}},
           .name = "a"},
            "one plane"}})
    EXPECT_THAT(line(voxels.data(), layout), AllOf(testing::StartsWith("a: "), HasSubstr(said)));
  EXPECT_THAT(errorOf([&] {
                Volume::fromFunction({}, {.dims = {4, 4, 4}, .type = "u8"});
              }),
              HasSubstr("expected a function"));
}

}  // namespace
}  // namespace sluice
