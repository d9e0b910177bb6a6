// Boxes whose texels are not voxels: levels of other resolutions in the index space of the full
// one, against the picture of the full resolution, answers that follow from a ray and the plain
// device.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/device/suite_device.h"
#include "tests/support/float_picture.h"
#include "tests/support/plain_device.h"

namespace sluice::texel_map_test {
namespace {

constexpr Vec3i kDims{41, 33, 25};
using ValueAt = std::function<double(Vec3d)>;

double rampAt(Vec3d p) {
  return 30 + 2.5 * p.x + 1.5 * p.y + 2 * p.z;
}
double noiseAt(Vec3d p) {
  const auto i = static_cast<uint32_t>(std::llround(p.x * 7919 + p.y * 104729 + p.z * 1299709));
  return static_cast<double>((i * 2654435761U) >> 24);
}

// A level whose voxels are means of `factor` voxels along each axis, `axes` of it as the chunk's,
// in a chunk that also has `border` texels beyond it on every side.
struct Level {
  Vec3i factor{1, 1, 1};
  std::array<int, 3> axes{0, 1, 2};
  Vec3i border{1, 1, 1};

  TexelMap texels() const {
    TexelMap map;
    map.axes = axes;
    for (int a = 0; a < 3; ++a) {
      const auto f = static_cast<double>(factor[axes[static_cast<size_t>(a)]]);
      map.scale[a] = 1 / f;
      map.offset[a] = static_cast<double>(border[a]) - (f - 1) / (2 * f);
    }
    return map;
  }
  // Its texels have the values at their centres.
  ChunkTexelsPtr chunk(const ValueAt& value_at, DeviceType type) const {
    const TexelMap map = texels();
    Vec3i size;
    for (int a = 0; a < 3; ++a) {
      const auto axis = axes[static_cast<size_t>(a)];
      size[a] = ceilDiv(kDims[axis], factor[axis]) + 2 * border[a];
    }
    std::vector<std::byte> bytes;
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y)
        for (int64_t x = 0; x < size.x; ++x) {
          const Vec3d in_chunk = (toDouble(Vec3i{x, y, z}) - map.offset) / map.scale;
          Vec3d p;
          for (int a = 0; a < 3; ++a) p[axes[static_cast<size_t>(a)]] = in_chunk[a];
          visitDeviceType(type, [&](auto tag) {
            const auto texel = static_cast<decltype(tag)>(value_at(p));
            const auto* from = reinterpret_cast<const std::byte*>(&texel);
            bytes.insert(bytes.end(), from, from + sizeof texel);
          });
        }
    return chunkTexels(size, type, bytes);
  }
};

struct Seen {
  Projection projection = Projection::kOrtho;
  Mode mode = Mode::kComposite;
  bool lit = false, with_gradients = false;
  double step = 1;

  std::string words() const {
    return fmt::format("projection {} mode {} lit {} gradients {} step {}",
                       static_cast<int>(projection), static_cast<int>(mode), lit, with_gradients,
                       step);
  }
};

FrameSetup setupOf(const Seen& seen, DeviceType type, const Vec3d& spacing = {1, 1.2, 0.9}) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.spacing = spacing;
  FrameOptions options;
  options.camera.projection = seen.projection;
  options.camera.azimuth_deg = 36;
  options.camera.elevation_deg = 27;
  options.size = {45, 39};
  options.step_vox = seen.step;
  options.mode = seen.mode;
  TransferFunction transfer{
      {{0, {0.1, 0.3, 0.9}}, {255, {1, 0.6, 0.1}}}, {{0, 0.01}, {255, 0.12}}, "t"};
  if (seen.with_gradients) transfer.gradients = {{0.5, {{0, 0.2}}}, {6, {{0, 1}}}};
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, {0, 255}), map, options);
  setup.type = type;
  setup.lit = seen.lit;
  setup.window = {0, 255};
  setup.depth_colors = {{1, 0.6, 0.1}, {0.1, 0.3, 0.9}};
  return setup;
}

// Away from the outer texels of levels up to factors of 4, and from cells lit by them.
constexpr Box3 kInner{{8, 8, 8}, {33, 25, 17}};

// `cells` cut at x = 21, front to back; the parts on the two sides from chunks 1 and 2.
std::vector<BoxDraw> boxesOf(const FrameSetup& setup, const Box3& cells, const Level& left,
                             const Level& right) {
  const double way = setup.rays.step0.x + setup.rays.step_dx.x * 22 + setup.rays.step_dy.x * 20;
  std::vector<BoxDraw> boxes(2);
  boxes[0].chunk = 1;
  boxes[0].cells = intersect(cells, {{0, 0, 0}, {21, 99, 99}});
  boxes[0].texels = left.texels();
  boxes[1].chunk = 2;
  boxes[1].cells = intersect(cells, {{21, 0, 0}, {99, 99, 99}});
  boxes[1].texels = right.texels();
  if (way < 0) std::swap(boxes[0], boxes[1]);
  return boxes;
}

Picture drawOn(Device& device, const FrameSetup& setup, const ValueAt& value_at, const Level& left,
               const Level& right, const Box3& cells = kInner, uint64_t* samples = nullptr) {
  device.makeResident(1, left.chunk(value_at, setup.type));
  device.makeResident(2, right.chunk(value_at, setup.type));
  const std::vector<BoxDraw> boxes = boxesOf(setup, cells, left, right);
  device.beginFrame(setup);
  device.draw(boxes);
  Picture picture = device.endFrame();
  if (samples != nullptr) *samples = device.countSamples(boxes);
  device.evict(1);
  device.evict(2);
  return picture;
}

double worstOf(const Picture& a, const Picture& b) {
  double worst = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i)
    worst = std::max(worst, std::abs(255.0 * a.rgba[i] - 255.0 * b.rgba[i]));
  return worst;
}
double shownShare(const Picture& picture) {
  size_t shown = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) shown += picture.rgba[i] > 0.05 ? 1 : 0;
  return 4.0 * static_cast<double>(shown) / static_cast<double>(picture.rgba.size());
}

std::vector<Seen> composites() {
  std::vector<Seen> result;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const auto& [lit, with_gradients] :
         {std::pair{false, false}, {true, false}, {false, true}, {true, true}})
      result.push_back({projection, Mode::kComposite, lit, with_gradients, 0.7});
  return result;
}

const Level kFine;
const Level kCoarse[] = {{{2, 2, 2}, {0, 1, 2}, {1, 1, 1}}, {{2, 2, 2}, {1, 2, 0}, {3, 1, 2}},
                         {{4, 4, 4}, {0, 1, 2}, {1, 1, 1}}, {{1, 2, 4}, {2, 0, 1}, {1, 2, 1}},
                         {{3, 3, 3}, {0, 1, 2}, {1, 1, 1}}, {{3, 1, 2}, {1, 2, 0}, {1, 1, 1}}};

class TexelMapTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { device_ = suiteDevice(); }
  static void TearDownTestSuite() { device_.reset(); }
  static inline std::unique_ptr<Device> device_;
};

// Its gradient is the same at any resolution, and means of it are its values.
TEST_F(TexelMapTest, aRampLooksTheSameAtAnyResolution) {
  PlainDevice plain;
  for (const Seen& seen : composites()) {
    const FrameSetup setup = setupOf(seen, DeviceType::kF32);
    for (Device* device : {device_.get(), static_cast<Device*>(&plain)}) {
      const Picture fine = drawOn(*device, setup, rampAt, kFine, kFine);
      EXPECT_GT(shownShare(fine), 0.1);
      for (const Level& coarse : kCoarse) {
        SCOPED_TRACE(fmt::format("{}: {}, factors {} {} {}", device->backend(), seen.words(),
                                 coarse.factor.x, coarse.factor.y, coarse.factor.z));
        EXPECT_LT(worstOf(drawOn(*device, setup, rampAt, coarse, coarse), fine), 1);
        EXPECT_LT(worstOf(drawOn(*device, setup, rampAt, kFine, coarse), fine), 1);
        EXPECT_LT(worstOf(drawOn(*device, setup, rampAt, coarse, kFine), fine), 1);
      }
    }
  }
}

// The share of pixels whose numbers differ by more than this, of 255.
double shareBeyond(double most, const Picture& a, const Picture& b) {
  int64_t beyond = 0;
  for (size_t i = 0; i < a.rgba.size(); i += 4)
    beyond += difference255(a.rgba, b.rgba, i / 4) > most ? 1 : 0;
  return static_cast<double>(beyond) / static_cast<double>(a.rgba.size() / 4);
}

// Includes the volume's faces, where samples lie beyond the outermost texels.
TEST_F(TexelMapTest, anyTexelsGiveThePictureOfPlainLoops) {
  PlainDevice plain;
  const Box3 all = boxOf(kDims - Vec3i{1, 1, 1});
  std::vector<Seen> seen = composites();
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective})
    for (const Mode mode :
         {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip, Mode::kDepthMip})
      seen.push_back({projection, mode, false, false, 0.7});
  const Level bare{{2, 2, 2}, {0, 1, 2}, {0, 0, 0}};
  for (const DeviceType type : {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32})
    for (const Seen& how : seen) {
      const FrameSetup setup = setupOf(how, type);
      for (const auto& [left, right] :
           {std::pair{kCoarse[0], kFine}, {kCoarse[3], kCoarse[4]}, {bare, bare}}) {
        SCOPED_TRACE(fmt::format("{}, {}, factors {} {} {}", name(type), how.words(), left.factor.x,
                                 left.factor.y, left.factor.z));
        uint64_t samples = 0, plain_samples = 0;
        const Picture drawn = drawOn(*device_, setup, noiseAt, left, right, all, &samples);
        const Picture expected = drawOn(plain, setup, noiseAt, left, right, all, &plain_samples);
        // Of noise, rounding chooses between almost equal values of different depths.
        if (how.mode == Mode::kDepthMip)
          EXPECT_LT(shareBeyond(2, drawn, expected), 0.005);
        else
          EXPECT_LT(worstOf(drawn, expected), 2);
        EXPECT_NEAR(static_cast<double>(samples), static_cast<double>(plain_samples),
                    2e-3 * static_cast<double>(plain_samples));
      }
    }
}

double wavesAt(Vec3d p) {
  return 128 + 70 * std::sin(p.x / 4) * std::cos(p.y / 5) + 50 * std::sin(p.z / 3 + 0.3);
}

// Texels lie thirds of themselves beside voxels, which no float is, and rays that touch a surface
// tell parts of a texel.
TEST_F(TexelMapTest, surfacesLieWhereThoseOfPlainLoopsDo) {
  PlainDevice plain;
  for (const DeviceType type : {DeviceType::kU8, DeviceType::kF32})
    for (const Level& level : {kCoarse[0], kCoarse[4], kCoarse[5], Level{{5, 7, 6}}}) {
      SCOPED_TRACE(fmt::format("{}, factors {} {} {}", name(type), level.factor.x, level.factor.y,
                               level.factor.z));
      FrameSetup setup = setupOf({.step = 0.7}, type);
      setup.size = {450, 390};
      for (auto& row : {&setup.rays.origin_dx, &setup.rays.origin_dy}) *row = *row * 0.1;
      LookUp look_up = *setup.look_up;
      look_up.surfaces = {{120.3, 1, {1, 0.3, 0.1}}};
      for (size_t i = 3; i < look_up.rgba.size(); i += 4) look_up.rgba[i] = 0;
      setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
      setup.has_surfaces = true;
      const Picture drawn = drawOn(*device_, setup, wavesAt, level, level);
      EXPECT_GT(shownShare(drawn), 0.05);
      EXPECT_LE(shareBeyond(2, drawn, drawOn(plain, setup, wavesAt, level, level)), 2e-5);
    }
}

// Along an axis of the volume rays meet the texels themselves.
TEST_F(TexelMapTest, extremesAreThoseOfTheTexels) {
  PlainDevice plain;
  const Level coarse{{1, 1, 4}, {0, 1, 2}, {1, 1, 1}};
  Seen seen;
  seen.mode = Mode::kMip;
  FrameSetup setup = setupOf(seen, DeviceType::kF32, {1, 1, 1});
  // A pixel a voxel, from the front.
  setup.size = {static_cast<int>(kDims.x), static_cast<int>(kDims.y)};
  setup.rays = {{-0.5, -0.5, 40}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {}, {}};
  setup.clip_from_index = {{{2.0 / kDims.x, 0, 0, 1.0 / kDims.x - 1},
                            {0, 2.0 / kDims.y, 0, 1.0 / kDims.y - 1},
                            {0, 0, 0, 1}}};
  for (Device* device : {device_.get(), static_cast<Device*>(&plain)}) {
    const Picture picture = drawOn(*device, setup, noiseAt, coarse, coarse);
    for (int64_t y = kInner.lo.y + 1; y < kInner.hi.y; ++y)
      for (int64_t x = kInner.lo.x + 1; x < kInner.hi.x; ++x) {
        const auto row = static_cast<size_t>(picture.height - 1 - y);
        const auto at = 4 * (row * static_cast<size_t>(picture.width) + static_cast<size_t>(x));
        double most = 0;  // centres of texels that stand for 4 k to 4 k + 3
        for (double z = 9.5; z <= 17; z += 4)
          most = std::max(most, noiseAt({double(x), double(y), z}));
        const double red = 0.1 + 0.9 * most / 255;
        ASSERT_NEAR(picture.rgba[at], red, 1.5 / 255) << device->backend() << x << ' ' << y;
      }
  }
}

}  // namespace
}  // namespace sluice::texel_map_test
