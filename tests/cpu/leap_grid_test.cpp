// Checks cell by cell which bricks may be leapt over, and that pictures are the same with and
// without leaps.
#include "src/cpu/leap_grid.h"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "src/device/shading/look_up_texels.h"
#include "src/render/camera/frame_setup.h"
#include "tests/cpu/test_device.h"
#include "tests/support/plain_device.h"

namespace sluice::leap_grid_test {
namespace {

constexpr Vec3i kDims{45, 38, 41};

// Opaque from `least` to `most`, entries a device value.
LookUp showing(double least, double most, bool interpolates = false) {
  LookUp look_up;
  look_up.device_range = {0, 255};
  look_up.interpolates = interpolates;
  for (int entry = 0; entry < 256; ++entry) {
    const float opacity = entry >= least && entry <= most ? 0.05F : 0.0F;
    look_up.rgba.insert(look_up.rgba.end(),
                        {0.2F + static_cast<float>(entry) / 400, 0.5F, 0.9F, opacity});
  }
  return look_up;
}

// A few small balls in a lot of nothing that is not even.
int valueAt(Vec3i at) {
  const int noise = static_cast<int>((at.x * 7 + at.y * 13 + at.z * 5) % 23);
  for (const Vec3d centre : {Vec3d{9, 8, 30}, Vec3d{33, 25, 9}, Vec3d{20, 30, 22}}) {
    const Vec3d way = toDouble(at) - centre;
    const double distance = std::sqrt(dot(way, way));
    if (distance < 5) return 200 - static_cast<int>(distance * 15);
  }
  return noise;
}

ChunkTexelsPtr texelsOf(DeviceType type) {
  std::vector<std::byte> bytes(static_cast<size_t>(volume(kDims)) * bytesPerVoxel(type));
  size_t i = 0;
  for (int64_t z = 0; z < kDims.z; ++z)
    for (int64_t y = 0; y < kDims.y; ++y)
      for (int64_t x = 0; x < kDims.x; ++x, ++i)
        visitDeviceType(type, [&](auto tag) {
          auto texel = static_cast<decltype(tag)>(valueAt({x, y, z}));
          if constexpr (std::is_same_v<decltype(tag), float>)
            if (x + 2 * y + z == 40) texel = kNotANumber;
          std::memcpy(bytes.data() + i * sizeof(texel), &texel, sizeof(texel));
        });
  return chunkTexels(kDims, type, bytes);
}

size_t placeOf(const LeapGrid& grid, Vec3i brick) {
  return static_cast<size_t>((brick.z * grid.bricks.y + brick.y) * grid.bricks.x + brick.x);
}

template <class F>
void eachBrick(const LeapGrid& grid, F&& visit) {
  for (int64_t z = 0; z < grid.bricks.z; ++z)
    for (int64_t y = 0; y < grid.bricks.y; ++y)
      for (int64_t x = 0; x < grid.bricks.x; ++x) visit(Vec3i{x, y, z});
}

// By the texels themselves: some of the brick's is at least `least`.
bool reaches(Vec3i brick, int least) {
  for (int64_t z = brick.z * kBrickSide; z <= (brick.z + 1) * kBrickSide && z < kDims.z; ++z)
    for (int64_t y = brick.y * kBrickSide; y <= (brick.y + 1) * kBrickSide && y < kDims.y; ++y)
      for (int64_t x = brick.x * kBrickSide; x <= (brick.x + 1) * kBrickSide && x < kDims.x; ++x)
        if (valueAt({x, y, z}) >= least) return true;
  return false;
}

void expectNearestDistances(DeviceType type) {
  const ChunkTexelsPtr texels = texelsOf(type);
  LeapGrid grid = leapGrid(*texels);
  EXPECT_EQ(grid.bricks, (Vec3i{11, 10, 10}));
  setDistances(grid, type, shownValues(showing(100, 255)));
  std::vector<Vec3i> shown;
  eachBrick(grid, [&](Vec3i brick) {
    if (reaches(brick, 99)) shown.push_back(brick);
  });
  ASSERT_GT(shown.size(), 10U);
  EXPECT_DOUBLE_EQ(grid.shown_share,
                   static_cast<double>(shown.size()) / static_cast<double>(volume(grid.bricks)));
  int far = 0;
  eachBrick(grid, [&](Vec3i brick) {
    int64_t nearest = kMostDistance;
    for (const Vec3i other : shown) {
      const Vec3i way = brick - other;
      nearest = std::min(nearest, std::max({std::abs(way.x), std::abs(way.y), std::abs(way.z)}));
    }
    EXPECT_EQ(grid.distances[placeOf(grid, brick)], nearest)
        << brick.x << ' ' << brick.y << ' ' << brick.z;
    far += nearest > 2 ? 1 : 0;
  });
  EXPECT_GT(far, 100) << "the volume is too full to tell";
  // Another look, the same ranges.
  setDistances(grid, type, shownValues(showing(0, 255)));
  EXPECT_EQ(grid.shown_share, 1);
  setDistances(grid, type, shownValues(showing(250, 255)));
  EXPECT_EQ(grid.shown_share, 0);
  eachBrick(grid,
            [&](Vec3i brick) { EXPECT_EQ(grid.distances[placeOf(grid, brick)], kMostDistance); });
}

// A chunk is stored in whole pages.
TEST(LeapGrid, texelsBehindThoseOfItsBlocksDoNotCount) {
  const ChunkTexelsPtr small = texelsOf(DeviceType::kU8);
  ChunkTexels stored = *small;
  stored.storage_vox = kDims + Vec3i{19, 10, 7};
  stored.byte_count = static_cast<size_t>(volume(stored.storage_vox));
  stored.bytes = std::make_shared<std::byte[]>(stored.byte_count);
  std::memset(stored.bytes.get(), 200, stored.byte_count);
  for (int64_t z = 0; z < kDims.z; ++z)
    for (int64_t y = 0; y < kDims.y; ++y)
      std::memcpy(stored.bytes.get() + (z * stored.storage_vox.y + y) * stored.storage_vox.x,
                  small->bytes.get() + (z * kDims.y + y) * kDims.x, static_cast<size_t>(kDims.x));
  for (const int64_t margin : {0, 1}) {
    const LeapGrid expected = leapGrid(*small, nullptr, margin);
    const LeapGrid grid = leapGrid(stored, nullptr, margin);
    EXPECT_EQ(grid.bricks, expected.bricks);
    EXPECT_EQ(grid.ranges, expected.ranges);
  }
}

TEST(LeapGridTest, distancesAreThoseToTheNearestBrickThatShowsSomething) {
  expectNearestDistances(DeviceType::kU8);
  expectNearestDistances(DeviceType::kU16);
}

// Bytes are looked up by their least greater value that shows something: the same answers.
TEST(LeapGridTest, bytesShowWhatTheirIntervalShows) {
  for (const bool interpolates : {false, true}) {
    const ShownValues shown = shownValues(showing(40, 60, interpolates));
    LeapGrid grid;
    grid.bricks = {256, 256, 1};
    for (int lo = 0; lo < 256; ++lo)
      for (int hi = 0; hi < 256; ++hi)
        grid.ranges.insert(grid.ranges.end(),
                           {static_cast<std::byte>(lo), static_cast<std::byte>(hi)});
    setDistances(grid, DeviceType::kU8, shown);
    for (int lo = 0; lo < 256; ++lo)
      for (int hi = 0; hi < 256; ++hi)
        ASSERT_EQ(grid.distances[static_cast<size_t>(256 * lo + hi)] == 0,
                  shown.anyIn(static_cast<float>(lo), static_cast<float>(hi)))
            << lo << ' ' << hi;
  }
}

TEST(LeapGridTest, valuesBetweenTwoThatShowNothingMayShowSomething) {
  const ShownValues band = shownValues(showing(40, 60));
  EXPECT_TRUE(band.anyIn(10, 200));
  EXPECT_TRUE(band.anyIn(60, 200));
  EXPECT_TRUE(band.anyIn(10, 40));
  EXPECT_TRUE(band.anyIn(50, 50));
  EXPECT_TRUE(band.anyIn(10, 38.6)) << "the entry beside the nearest one shows something";
  EXPECT_FALSE(band.anyIn(10, 38.4));
  EXPECT_TRUE(band.anyIn(61.4, 255));
  EXPECT_FALSE(band.anyIn(61.6, 255));
  EXPECT_FALSE(band.anyIn(3e38, -3e38)) << "no value at all";
}

struct Drawn {
  Picture picture;
  uint64_t taken = 0;
};
// Requires: the volume is the device's chunk 1.
Drawn drawOn(CpuDevice& device, FrameSetup setup, bool leaps, bool counts = true) {
  setup.skips = leaps;
  setup.counts_taken = counts;
  std::vector<BoxDraw> boxes;
  // The whole depth, and parts that begin within bricks.
  for (const auto& [lo, hi] : {std::pair<int64_t, int64_t>{0, 19}, {19, 22}, {22, kDims.z - 1}}) {
    BoxDraw box;
    box.chunk = 1;
    box.cells = {{1, 0, lo}, {kDims.x - 1, kDims.y - 2, hi}};
    boxes.push_back(box);
  }
  const double way = setup.rays.step0.z + setup.rays.step_dx.z * 30 + setup.rays.step_dy.z * 30;
  if (way < 0) std::ranges::reverse(boxes);
  device.beginFrame(setup);
  device.draw(boxes);
  Drawn drawn{device.endFrame(), 0};
  if (counts) drawn.taken = device.takenSamples();
  return drawn;
}

Drawn draw(SimdTarget target, const FrameSetup& setup, bool leaps) {
  TestCpuDevice device(target);
  device.makeResident(1, texelsOf(setup.type));
  return drawOn(device, setup, leaps);
}

FrameSetup setupOf(const VolumeLayout& layout, const FrameOptions& options,
                   const std::vector<OpacityPoint>& opacities) {
  const ValueMap map = deviceMap(layout);
  const TransferFunction transfer{{{0, {0.2, 0.3, 0.9}}, {255, {1, 0.6, 0.1}}}, opacities, "t"};
  return frameSetup(resolve(options, layout), layout, OpacityTable(transfer, map, {0, 255}), map,
                    options);
}

TEST(LeapGridTest, leapingLeavesOutSamplesAndNothingOfThePicture) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.spacing = {1, 1.1, 0.8};
  for (const SimdTarget target : simdTargets())
    for (const DeviceType type : {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32})
      for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
        for (const double azimuth : {0.0, 33.0, 200.0}) {
          FrameOptions options;
          options.camera.projection = projection;
          options.camera.azimuth_deg = azimuth;
          options.camera.elevation_deg = azimuth / 10;
          options.size = {67, 59};
          options.step_vox = 0.6;
          FrameSetup setup = setupOf(layout, options, {{0, 0}, {99, 0}, {100, 0.1}, {255, 0.3}});
          setup.type = type;
          for (const bool lit : {false, true}) {
            setup.lit = lit;
            SCOPED_TRACE(fmt::format("{}, {}, projection {}, azimuth {}, lit {}", name(target),
                                     name(type), static_cast<int>(projection), azimuth, lit));
            const Drawn all = draw(target, setup, false), leapt = draw(target, setup, true);
            EXPECT_EQ(all.picture.rgba, leapt.picture.rgba);
            EXPECT_LT(leapt.taken, all.taken / 3);
            EXPECT_GT(leapt.taken, 1000U);
          }
        }
}

// Includes rays that end because nothing behind is seen.
TEST(LeapGridTest, aFrameThatCountsIsTheFrameThatDraws) {
  VolumeLayout layout;
  layout.dims = kDims;
  FrameOptions options;
  options.size = {67, 59};
  for (const SimdTarget target : simdTargets())
    for (const DeviceType type : {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32}) {
      SCOPED_TRACE(fmt::format("{}, {}", name(target), name(type)));
      FrameSetup setup = setupOf(layout, options, {{0, 0}, {4, 0}, {5, 0.7}, {255, 0.9}});
      setup.type = type;
      TestCpuDevice device(target);
      device.makeResident(1, texelsOf(type));
      const Drawn plain = drawOn(device, setup, true, false);
      const Drawn counting = drawOn(device, setup, true);
      EXPECT_EQ(counting.picture.rgba, plain.picture.rgba);
      const Drawn all = drawOn(device, setup, false);
      EXPECT_LT(counting.taken, all.taken / 2);
      size_t shown = 0;
      for (size_t i = 3; i < plain.picture.rgba.size(); i += 4)
        shown += plain.picture.rgba[i] > 0 ? 1 : 0;
      EXPECT_GE(counting.taken, shown);
    }
}

// A device keeps distances with its chunks: they belong to the frame's look, whatever was drawn
// between.
TEST(LeapGridTest, leapsFollowTheLook) {
  VolumeLayout layout;
  layout.dims = kDims;
  FrameOptions options;
  options.size = {67, 59};
  const FrameSetup balls = setupOf(layout, options, {{0, 0}, {99, 0}, {100, 0.1}, {255, 0.3}});
  const FrameSetup centres = setupOf(layout, options, {{0, 0}, {189, 0}, {190, 0.2}, {255, 0.3}});
  const FrameSetup noise = setupOf(layout, options, {{0, 0}, {9, 0.1}, {10, 0.1}, {22, 0}});
  TestCpuDevice kept;
  kept.makeResident(1, texelsOf(DeviceType::kU8));
  kept.makeResident(2, texelsOf(DeviceType::kU8));  // a chunk that no frame draws
  for (const FrameSetup* setup : {&balls, &centres, &balls, &noise, &centres, &noise, &balls}) {
    const Drawn expected = draw(SimdTarget::kAuto, *setup, false);
    const Drawn drawn = drawOn(kept, *setup, true);
    EXPECT_EQ(drawn.picture.rgba, expected.picture.rgba);
    if (setup != &noise) {
      EXPECT_LT(drawn.taken, expected.taken / 3);
    }
  }
}

// A device keeps the bricks of a chunk that was evicted, too: not for other texels, even at the
// same address.
TEST(LeapGridTest, aChunkThatComesBackLeapsAsBefore) {
  VolumeLayout layout;
  layout.dims = kDims;
  FrameOptions options;
  options.size = {67, 59};
  const FrameSetup setup = setupOf(layout, options, {{0, 0}, {99, 0}, {100, 0.1}, {255, 0.3}});
  const Drawn expected = draw(SimdTarget::kAuto, setup, true);
  TestCpuDevice kept;
  ChunkTexelsPtr texels = texelsOf(DeviceType::kU8);
  for (int turn = 0; turn < 3; ++turn) {
    kept.makeResident(1, texels);
    const Drawn drawn = drawOn(kept, setup, true);
    EXPECT_EQ(drawn.picture.rgba, expected.picture.rgba);
    EXPECT_EQ(drawn.taken, expected.taken);
    kept.evict(1);
  }
  for (int turn = 0; turn < 20; ++turn) {
    texels.reset();
    const auto value = static_cast<std::byte>(turn % 2 == 0 ? 0 : 200);
    texels = chunkTexels(kDims, DeviceType::kU8,
                         std::vector<std::byte>(static_cast<size_t>(volume(kDims)), value));
    kept.makeResident(1, texels);
    const Picture picture = drawOn(kept, setup, true).picture;
    const bool shows = std::ranges::any_of(picture.rgba, [](float part) { return part > 0; });
    EXPECT_EQ(shows, turn % 2 != 0);
    kept.evict(1);
  }
}

}  // namespace
}  // namespace sluice::leap_grid_test
