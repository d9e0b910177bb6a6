// The device alone: chunks and boxes given by hand, without a session, a cache or blocks.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "src/base/error.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice {
namespace {

constexpr Vec3i kDims{8, 8, 8};

// Voxels by their position, 0 elsewhere.
std::vector<std::byte> voxelsWith(std::initializer_list<std::pair<Vec3i, int>> voxels) {
  std::vector<std::byte> bytes(static_cast<size_t>(volume(kDims)));
  for (const auto& [at, value] : voxels)
    bytes[static_cast<size_t>((at.z * kDims.y + at.y) * kDims.x + at.x)] =
        static_cast<std::byte>(value);
  return bytes;
}

class DeviceTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { device_ = suiteDevice(); }
  static void TearDownTestSuite() { device_.reset(); }
  static Device& device() { return *device_; }

  // Looks along -z, a pixel a tenth of a voxel: (x, y, z) is at column 10 x + 45, row 115 - 10 y of
  // 161 x 161.
  static FrameSetup straightSetup(const TransferFunction& transfer, FrameOptions options = {}) {
    VolumeLayout layout;
    layout.dims = kDims;
    options.size = {161, 161};
    View view = resolve(options, layout);
    view.half_height = 8.05;
    view.eye = {3.5, 3.5, 20};
    view.first_depth = 13;
    const ValueMap map = deviceMap(layout);
    return frameSetup(view, layout, OpacityTable(transfer, map, {0, 255}), map, options);
  }
  // How many of so many given bytes the device copies: none if it borrows.
  static uint64_t copied(uint64_t bytes) {
    return device().limits().texels == TexelPlace::kBorrowed ? 0 : bytes;
  }
  static BoxDraw wholeBox() {
    BoxDraw box;
    box.cells = boxOf(kDims - Vec3i{1, 1, 1});
    return box;
  }
  static void draw(uint64_t chunk, std::span<const BoxDraw> boxes) {
    std::vector<BoxDraw> from(boxes.begin(), boxes.end());
    for (BoxDraw& box : from) box.chunk = chunk;
    device().draw(from);
  }
  static std::array<float, 4> pixel(const Picture& picture, int x, int y) {
    const float* p = &picture.rgba[static_cast<size_t>(4 * (y * picture.width + x))];
    return {p[0], p[1], p[2], p[3]};
  }

 private:
  static inline std::unique_ptr<Device> device_;
};

TransferFunction visibleAbove(double value, Vec3d rgb = {1, 1, 1}, double opacity = 0.5) {
  return {{{0, rgb}}, {{value, 0}, {255, opacity}}, "above"};
}

TEST_F(DeviceTest, limitsAreUsable) {
  const DeviceLimits limits = device().limits();
  EXPECT_GE(limits.max_picture_size, 1024);
  EXPECT_NE(std::string(device().backend()), "");
  EXPECT_NE(std::string(device().renderer()), "");
}

TEST_F(DeviceTest, voxelsAppearWhereTheyLie) {
  const auto texels = voxelsWith({{{1, 6, 4}, 255}});
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, texels));
  device().beginFrame(straightSetup(visibleAbove(0)));
  const BoxDraw box = wholeBox();
  draw(1, {&box, 1});
  const Picture picture = device().endFrame();
  device().evict(1);
  // The whole picture's light has its centre at the voxel: x = 1 to the left, y = 6 to the top.
  double sum = 0, x_sum = 0, y_sum = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const double weight = pixel(picture, x, y)[3];
      sum += weight;
      x_sum += weight * x;
      y_sum += weight * y;
    }
  EXPECT_GT(sum, 0);
  EXPECT_NEAR(x_sum / sum, 55, 0.5);
  EXPECT_NEAR(y_sum / sum, 55, 0.5);
}

// Nothing is left of a picture that was given back, neither its size nor its depth.
TEST_F(DeviceTest, reusedMemoryHoldsTheNewPicture) {
  const auto texels = voxelsWith({{{1, 6, 4}, 255}, {{5, 2, 3}, 180}});
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, texels));
  const BoxDraw box = wholeBox();
  const auto drawn = [&] {
    device().beginFrame(straightSetup(visibleAbove(0)));
    draw(1, {&box, 1});
    return device().endFrame();
  };
  const Picture fresh = drawn();
  for (const PictureSize size : {PictureSize{200, 190}, {3, 2}, {161, 161}}) {
    Picture old;
    old.width = size.width;
    old.height = size.height;
    old.rgba.assign(4 * static_cast<size_t>(size.width) * static_cast<size_t>(size.height), 0.7F);
    old.depth.assign(old.rgba.size() / 4, 0.7F);
    const float* memory = old.rgba.data();
    device().reuse(std::move(old));
    const Picture again = drawn();
    EXPECT_EQ(again.rgba, fresh.rgba);
    EXPECT_EQ(again.width, fresh.width);
    EXPECT_EQ(again.height, fresh.height);
    EXPECT_TRUE(again.depth.empty());
    EXPECT_EQ(again.rgba.data() == memory, size.width >= 161) << "where the new one fits";
  }
  device().evict(1);
}

TEST_F(DeviceTest, frontBoxHidesTheOneBehind) {
  const auto full = std::vector<std::byte>(512, std::byte{255});
  const auto half = std::vector<std::byte>(512, std::byte{128});
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, full));
  device().makeResident(2, chunkTexels(kDims, DeviceType::kU8, half));
  // Opaque: 255 is red, 128 is green.
  const TransferFunction transfer{{{128, {0, 1, 0}}, {255, {1, 0, 0}}}, {{0, 1}}, "two"};
  BoxDraw front = wholeBox(), back = wholeBox();
  front.cells.lo.z = back.cells.hi.z = 3;
  device().beginFrame(straightSetup(transfer));
  draw(1, {&front, 1});
  draw(2, {&back, 1});
  EXPECT_EQ(pixel(device().endFrame(), 80, 80), (std::array{1.0F, 0.0F, 0.0F, 1.0F}));
  device().beginFrame(straightSetup(transfer));
  draw(2, {&back, 1});
  EXPECT_EQ(pixel(device().endFrame(), 80, 80), (std::array{0.0F, 1.0F, 0.0F, 1.0F}))
      << "the frame before is gone";
  device().evict(1);
  device().evict(2);
}

// A box may lie anywhere in a chunk, turned any of three ways, with other texels around it.
TEST_F(DeviceTest, placeAndTurnInTheChunkDoNotShow) {
  std::vector<std::byte> straight(512);
  for (size_t i = 0; i < straight.size(); ++i)
    straight[i] = static_cast<std::byte>((i * i + 7 * i) % 251);
  const TransferFunction transfer = visibleAbove(20, {0.3, 0.6, 0.9}, 0.2);
  FrameOptions options;
  options.camera.azimuth_deg = 30;
  options.camera.elevation_deg = 20;
  VolumeLayout layout;
  layout.dims = kDims;
  options.size = {80, 70};
  const View view = resolve(options.camera, layout, options.size, 0.5);
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(view, layout, OpacityTable(transfer, map, {0, 255}), map, options);
  for (const bool lit : {false, true}) {
    setup.lit = lit;
    std::optional<Picture> first;
    for (const std::array<int, 3>& axes : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}})
      for (const Vec3i at : {Vec3i{0, 0, 0}, {3, 1, 5}}) {
        const Vec3i storage{16, 12, 14};
        std::vector<std::byte> texels(static_cast<size_t>(volume(storage)), std::byte{77});
        for (int64_t z = 0; z < 8; ++z)
          for (int64_t y = 0; y < 8; ++y)
            for (int64_t x = 0; x < 8; ++x) {
              const Vec3i voxel{x, y, z};
              const Vec3i texel = at + Vec3i{voxel[axes[0]], voxel[axes[1]], voxel[axes[2]]};
              texels[static_cast<size_t>((texel.z * storage.y + texel.y) * storage.x + texel.x)] =
                  straight[static_cast<size_t>((z * 8 + y) * 8 + x)];
            }
        device().makeResident(5, chunkTexels(storage, DeviceType::kU8, texels));
        BoxDraw box;
        // Away from the faces, so that differences of lit samples stay inside.
        box.cells = {{1, 1, 1}, {6, 6, 6}};
        box.texels.axes = axes;
        box.texels.offset = toDouble(at);
        device().beginFrame(setup);
        draw(5, {&box, 1});
        const Picture picture = device().endFrame();
        device().evict(5);
        if (!first) first = picture;
        float largest = 0;
        for (size_t i = 0; i < picture.rgba.size(); ++i)
          largest = std::max(largest, std::abs(picture.rgba[i] - first->rgba[i]));
        EXPECT_LT(largest, 0.1 / 255) << "axis " << axes[2] << ", at " << at.x << ", lit " << lit;
      }
    EXPECT_GT(pixel(*first, 40, 35)[3], 0.1);
  }
}

// Look-ups are exact: each value of each type takes its own entry.
TEST_F(DeviceTest, valuesFindTheirColours) {
  TransferFunction transfer{{}, {{0, 1}}, "staircase"};
  for (const double v : {0.0, 64.0, 128.0, 192.0}) {
    const Vec3d rgb{v / 256, 1 - v / 256, 0.25};
    transfer.colors.push_back({v, rgb});
    transfer.colors.push_back({v + 63, rgb});
  }
  for (const DeviceType type : {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32})
    for (const int value : {0, 64, 127, 128, 191, 192, 255}) {
      std::vector<std::byte> texels(512 * bytesPerVoxel(type));
      for (size_t i = 0; i < 512; ++i)
        visitDeviceType(type, [&](auto tag) {
          const auto texel = static_cast<decltype(tag)>(value);
          std::memcpy(texels.data() + i * sizeof(texel), &texel, sizeof(texel));
        });
      FrameSetup setup = straightSetup(transfer);
      setup.type = type;
      device().makeResident(3, chunkTexels(kDims, type, texels));
      device().beginFrame(setup);
      const BoxDraw box = wholeBox();
      draw(3, {&box, 1});
      const auto found = pixel(device().endFrame(), 80, 80);
      device().evict(3);
      const Vec3d expected = colorAt(transfer, value);
      for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], expected[static_cast<int>(c)], 0.1 / 255)
            << name(type) << " " << value;
    }
}

// Also at a step of the transfer function, on which side of it rounding must not decide.
TEST_F(DeviceTest, aSegmentOfOneValueLooksAsASampleOfIt) {
  const std::vector<std::byte> bytes(static_cast<size_t>(volume(kDims)), std::byte{191});
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, bytes));
  const std::vector<ColorPoint> colors{{0, {0, 0.2, 1}}, {191, {0, 0.2, 1}}, {191, {1, 0.2, 0}}};
  for (const std::vector<OpacityPoint>& opacities : {
           std::vector<OpacityPoint>{{191, 0.6}, {191, 0}, {200, 0.3}},
           {{191, 0}, {191, 0.2}},
           {{100, 0}, {191, 0.2}, {191, 0.1}, {255, 0.3}},
           {{150, 0.1}},
       })
    for (const auto& [azimuth, projection] : {std::pair(0.0, Projection::kOrtho),
                                              {33.0, Projection::kOrtho},
                                              {71.0, Projection::kPerspective}}) {
      FrameOptions options;
      options.camera.azimuth_deg = azimuth;
      options.camera.projection = projection;
      options.size = {40, 40};
      VolumeLayout layout;
      layout.dims = kDims;
      const ValueMap map = deviceMap(layout);
      FrameSetup setup =
          frameSetup(resolve(options.camera, layout, options.size, 0.7), layout,
                     OpacityTable({colors, opacities, "step"}, map, {0, 255}), map, options);
      const auto drawn = [&] {
        device().beginFrame(setup);
        draw(1, {{wholeBox()}});
        return device().endFrame();
      };
      const Picture samples = drawn();
      setup.integrates = true;
      const Picture segments = drawn();
      for (size_t i = 0; i < samples.rgba.size(); ++i)
        ASSERT_NEAR(segments.rgba[i], samples.rgba[i], 1.0F / 255) << azimuth << ", number " << i;
    }
  device().evict(1);
}

TEST_F(DeviceTest, uploadsAndBindsAreCountedAtTheCall) {
  const uint64_t bytes_before = device().uploadedBytes(), binds_before = device().binds();
  const std::vector<std::byte> texels(512);
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, texels));
  device().makeResident(2, chunkTexels({4, 4, 4}, DeviceType::kU16, std::span(texels).first(128)));
  EXPECT_EQ(device().uploadedBytes() - bytes_before, copied(512U + 128));
  device().beginFrame(straightSetup(visibleAbove(0)));
  const BoxDraw boxes[] = {wholeBox(), wholeBox()};
  draw(1, boxes);
  device().endFrame();
  EXPECT_EQ(device().binds() - binds_before, 1U) << "one chunk, however many boxes";
  EXPECT_EQ(device().uploadedBytes() - bytes_before, copied(512U + 128))
      << "drawing uploads nothing";
  device().evict(1);
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, texels));
  EXPECT_EQ(device().uploadedBytes() - bytes_before, copied(2 * 512U + 128));
  device().evict(1);
  device().evict(2);
}

TEST_F(DeviceTest, moreBoxesThanOneDrawCallTakes) {
  const auto texels = std::vector<std::byte>(512, std::byte{200});
  device().makeResident(1, chunkTexels(kDims, DeviceType::kU8, texels));
  // A box for each slab of the first cell column, thousands of times: opaque at the first.
  std::vector<BoxDraw> boxes(12000, wholeBox());
  for (size_t i = 0; i < boxes.size(); ++i) {
    const auto x = static_cast<int64_t>(i % 7);
    boxes[i].cells = {{x, 0, 0}, {x + 1, 7, 7}};
  }
  device().beginFrame(straightSetup(visibleAbove(0, {1, 1, 1}, 1e-5)));
  draw(1, boxes);
  const Picture picture = device().endFrame();
  // 12000 / 7 boxes over each other, 7 samples each.
  const double expected = 1 - std::pow(1 - 1e-5 * 200 / 255, 7 * 12000.0 / 7);
  EXPECT_NEAR(pixel(picture, 80, 80)[3], expected, 0.01 * expected);
  EXPECT_EQ(device().countSamples(boxes) / 12000, device().countSamples({boxes.data(), 7}) / 7);
  device().evict(1);
}

TEST_F(DeviceTest, pictureBeyondTheLimitsIsAnErrorAndTheNextOneIsRight) {
  FrameSetup setup = straightSetup(visibleAbove(0));
  const PictureSize right = setup.size;
  setup.size = {static_cast<int>(device().limits().max_picture_size) + 1, 4};
  EXPECT_THROW(device().beginFrame(setup), Error);
  setup.size = right;
  device().beginFrame(setup);
  const Picture picture = device().endFrame();
  EXPECT_EQ(picture.width, right.width);
  EXPECT_EQ(picture.rgba.size(),
            static_cast<size_t>(right.width) * static_cast<size_t>(right.height) * 4);
}

}  // namespace
}  // namespace sluice
