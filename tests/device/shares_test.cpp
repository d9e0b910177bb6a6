// Chunks of labels whose texels know which share of the voxels below them has the label, against
// answers on paper and the plain device.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/draw_one_box.h"
#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice::shares_test {
namespace {

constexpr Vec3i kDims{23, 19, 17};
constexpr ValueRange kRange{0, 9};
constexpr DeviceType kTypes[] = {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32};

// A label, and the share of the voxels below the texel that have it.
struct Texel {
  int label = 0;
  double share = 1;
};
using TexelAt = std::function<Texel(int64_t)>;  // by its number

ChunkTexelsPtr chunkOf(const TexelAt& texel_at, DeviceType type, bool has_shares) {
  std::vector<std::byte> bytes;
  for (int64_t i = 0; i < volume(kDims); ++i) {
    const Texel texel = texel_at(i);
    const auto add = [&](double number) {
      visitDeviceType(type, [&](auto tag) {
        const auto value = static_cast<decltype(tag)>(number);
        const auto* from = reinterpret_cast<const std::byte*>(&value);
        bytes.insert(bytes.end(), from, from + sizeof value);
      });
    };
    add(texel.label);
    const double others = (1 - texel.share) * wholeShare(type);
    if (has_shares) add(type == DeviceType::kF32 ? others : std::round(others));
  }
  auto chunk = std::make_shared<ChunkTexels>(*chunkTexels(kDims, type, bytes));
  chunk->has_spread = has_shares;
  return chunk;
}

// Patches of labels with shares from a fifth to all.
Texel patchAt(int64_t i) {
  const int64_t x = i % kDims.x, y = i / kDims.x % kDims.y, z = i / (kDims.x * kDims.y);
  const int64_t patch = x / 3 + 7 * (y / 4) + 11 * (z / 3);
  return {static_cast<int>(patch * patch % 10), 0.2 + 0.2 * static_cast<double>((x + y + z) % 5)};
}

struct Seen {
  Projection projection = Projection::kOrtho;
  bool lit = false, is_opaque = false;
  std::string words() const {
    return fmt::format("projection {} lit {} opaque {}", static_cast<int>(projection), lit,
                       is_opaque);
  }
};

std::vector<Seen> allSeen() {
  std::vector<Seen> seen;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const bool lit : {false, true})
      for (const bool is_opaque : {false, true}) seen.push_back({projection, lit, is_opaque});
  return seen;
}

// Label 0 is hidden.
FrameSetup setupOf(const Seen& seen, DeviceType type) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.spacing = {1, 1.2, 0.9};
  FrameOptions options;
  options.camera.projection = seen.projection;
  options.camera.azimuth_deg = 36;
  options.camera.elevation_deg = 27;
  options.size = {45, 39};
  options.step_vox = 0.7;
  const double most = seen.is_opaque ? 1 : 0.15;
  TransferFunction transfer{{{0, {0.1, 0.3, 0.9}}, {5, {0.9, 0.9, 0.2}}, {9, {1, 0.6, 0.1}}},
                            {{0, 0}, {1, most}, {9, most}},
                            "t"};
  transfer.labels = true;
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, kRange), map, options);
  setup.type = type;
  setup.lit = seen.lit;
  return setup;
}

Picture drawBox(Device& device, const FrameSetup& setup, const ChunkTexelsPtr& chunk, Vec3i dims,
                Vec3d scale, Vec3d offset) {
  BoxDraw box;
  box.chunk = 1;
  box.cells = boxOf(dims - Vec3i{1, 1, 1});
  box.texels.scale = scale;
  box.texels.offset = offset;
  return drawOneBox(device, setup, chunk, box);
}
Picture drawOn(Device& device, const FrameSetup& setup, const ChunkTexelsPtr& chunk,
               Vec3d scale = {1, 1, 1}) {
  return drawBox(device, setup, chunk, kDims, scale, (Vec3d{1, 1, 1} - scale) * 3.0);
}

double worstOf(const Picture& a, const Picture& b) {
  double worst = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i)
    worst = std::max(worst, std::abs(255.0 * a.rgba[i] - 255.0 * b.rgba[i]));
  return worst;
}
// The share of pixels that differ by more than 2 of 255: labels have edges, at which rounding
// decides.
double differentShare(const Picture& a, const Picture& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    double worst = 0;
    for (size_t c = 0; c < 4; ++c)
      worst = std::max(worst, std::abs(255.0 * a.rgba[i + c] - 255.0 * b.rgba[i + c]));
    count += worst > 2 ? 1 : 0;
  }
  return 4 * static_cast<double>(count) / static_cast<double>(a.rgba.size());
}
double mostOpacity(const Picture& picture) {
  float most = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) most = std::max(most, picture.rgba[i]);
  return most;
}

class SharesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { device_ = suiteDevice(); }
  static void TearDownTestSuite() { device_.reset(); }
  static inline std::unique_ptr<Device> device_;
};

// Shares make a smooth edge beside a hidden label; where all show, whole labels are the labels
// alone.
TEST_F(SharesTest, ofOneAreThePictureOfLabelsThatAllShow) {
  const auto whole = [](int64_t i) { return Texel{std::max(1, patchAt(i).label), 1}; };
  for (const DeviceType type : kTypes)
    for (const Seen& seen : allSeen()) {
      const FrameSetup setup = setupOf(seen, type);
      const Picture one = drawOn(*device_, setup, chunkOf(whole, type, false));
      EXPECT_GT(mostOpacity(one), 0.1);
      EXPECT_LT(worstOf(drawOn(*device_, setup, chunkOf(whole, type, true)), one), 0.5)
          << name(type) << ' ' << seen.words();
    }
}

TEST_F(SharesTest, giveThePictureOfPlainLoops) {
  PlainDevice plain;
  for (const DeviceType type : kTypes)
    for (const Seen& seen : allSeen())
      for (const Vec3d scale : {Vec3d{1, 1, 1}, {0.5, 0.25, 0.5}}) {
        SCOPED_TRACE(fmt::format("{} {} scale {}", name(type), seen.words(), scale.x));
        const FrameSetup setup = setupOf(seen, type);
        const ChunkTexelsPtr chunk = chunkOf(patchAt, type, true);
        const Picture drawn = drawOn(*device_, setup, chunk, scale);
        EXPECT_LT(differentShare(drawn, drawOn(plain, setup, chunk, scale)), 0.01);
        // The shares show.
        EXPECT_GT(
            differentShare(drawn, drawOn(*device_, setup, chunkOf(patchAt, type, false), scale)),
            0.1);
      }
}

// A ray through n voxels of a label with a share keeps (1 - part * opacity)^n; the part is the
// share itself up to one half, and closer to a step the fuller they are.
TEST_F(SharesTest, theOpacityIsThatOfTheShareOfAVoxel) {
  PlainDevice plain;
  for (Device* device : {device_.get(), static_cast<Device*>(&plain)})
    for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
      for (const double side : {1.0, 2.0})
        for (const auto& [share, part] :
             {std::pair{0.2, 0.2}, {0.5, 0.5}, {0.6, 0.64}, {0.8, 1.0}}) {
          FrameSetup setup = setupOf({projection, false, true}, DeviceType::kF32);
          LookUp look_up = *setup.look_up;
          const auto with = [&](double opacity, double texel_share, bool has_shares) {
            LookUp other = look_up;
            for (size_t i = 7; i < other.rgba.size(); i += 4)
              other.rgba[i] = static_cast<float>(opacity);
            setup.look_up = std::make_shared<const LookUp>(other);
            const auto texel = [&](auto) { return Texel{4, texel_share}; };
            return drawOn(*device, setup, chunkOf(texel, DeviceType::kF32, has_shares),
                          Vec3d{1, 1, 1} * (1 / side));
          };
          const double voxel = part * (1 - std::pow(1 - 0.25, side));
          const Picture expected = with(1 - std::pow(1 - voxel, 1 / side), 1, false);
          EXPECT_GT(mostOpacity(expected), 0.2);
          EXPECT_LT(worstOf(with(0.25, share, true), expected), 1)
              << device->backend() << ' ' << share << ' ' << side;
        }
}

// A ball of label 4, in voxels of level 0 and in coarse ones, most of which it fills in part.
struct Ball {
  static constexpr int64_t kSide = 48;
  static bool has(Vec3i p) { return length(toDouble(p) - Vec3d{23.2, 24.1, 22.7}) < 15.3; }
  static Texel coarseAt(Vec3i at, int64_t factor) {
    int64_t count = 0;
    for (int64_t i = 0; i < factor * factor * factor; ++i)
      if (has(at * factor + Vec3i{i % factor, i / factor % factor, i / (factor * factor)})) ++count;
    const double share = static_cast<double>(count) / std::pow(static_cast<double>(factor), 3);
    return share > 0.5 ? Texel{4, share} : Texel{0, 1 - share};
  }
};

// The picture of the ball in voxels of level 0 (`factor` 1), or in coarse ones.
Picture ballPicture(Device& device, int64_t factor, double opacity) {
  VolumeLayout layout;
  layout.dims = {Ball::kSide, Ball::kSide, Ball::kSide};
  FrameOptions options;
  options.camera.azimuth_deg = 33;
  options.camera.elevation_deg = 21;
  options.size = {64, 64};
  options.step_vox = 0.5;
  TransferFunction transfer{
      {{0, {1, 1, 1}}, {9, {1, 1, 1}}}, {{0, 0}, {1, opacity}, {9, opacity}}, "t"};
  transfer.labels = true;
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, kRange), map, options);
  setup.type = DeviceType::kF32;
  const int64_t side = Ball::kSide / factor;
  std::vector<float> numbers;
  for (int64_t i = 0; i < side * side * side; ++i) {
    const Texel texel = Ball::coarseAt({i % side, i / side % side, i / (side * side)}, factor);
    numbers.push_back(static_cast<float>(texel.label));
    if (factor > 1) numbers.push_back(static_cast<float>(1 - texel.share));
  }
  const std::span<const std::byte> bytes = std::as_bytes(std::span(numbers));
  auto chunk = std::make_shared<ChunkTexels>(
      *chunkTexels({side, side, side}, DeviceType::kF32, {bytes.begin(), bytes.end()}));
  chunk->has_spread = factor > 1;
  const double scale = 1 / static_cast<double>(factor);
  return drawBox(device, setup, chunk, layout.dims, {scale, scale, scale},
                 Vec3d{1, 1, 1} * ((scale - 1) / 2));
}

// A coarse ball is as large as the fine one, and as opaque, though each voxel has one label:
// without what hidden labels leave of the voxels around it, it would be smaller by half a voxel.
TEST_F(SharesTest, aBallIsAsLargeInCoarseVoxels) {
  for (const double opacity : {0.03, 0.3, 1.0})
    for (const int64_t factor : {2, 4}) {
      const Picture fine = ballPicture(*device_, 1, opacity);
      const Picture coarse = ballPicture(*device_, factor, opacity);
      double area = 0, coarse_area = 0, off = 0;
      for (size_t i = 3; i < fine.rgba.size(); i += 4) {
        area += fine.rgba[i];
        coarse_area += coarse.rgba[i];
        off += std::abs(fine.rgba[i] - coarse.rgba[i]);
      }
      EXPECT_NEAR(coarse_area / area, 1, factor == 2 ? 0.015 : 0.04) << opacity << ' ' << factor;
      EXPECT_LT(off / area, factor == 2 ? 0.035 : 0.09) << opacity << ' ' << factor;
    }
}

TEST_F(SharesTest, leapingLeavesOutNothingThatShows) {
  for (const Seen& seen : allSeen()) {
    FrameSetup setup = setupOf(seen, DeviceType::kU8);
    const ChunkTexelsPtr chunk = chunkOf(
        [](int64_t i) {
          const int64_t x = i % kDims.x, z = i / (kDims.x * kDims.y);
          return x > 14 && z < 9 ? patchAt(i) : Texel{0, 0.7};
        },
        DeviceType::kU8, true);
    setup.skips = false;
    const Picture whole = drawOn(*device_, setup, chunk);
    setup.skips = true;
    EXPECT_GT(mostOpacity(whole), 0.1);
    EXPECT_LT(worstOf(drawOn(*device_, setup, chunk), whole), 0.5) << seen.words();
  }
}

}  // namespace
}  // namespace sluice::shares_test
