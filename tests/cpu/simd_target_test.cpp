// Every target draws the picture of the plain loops in tests/support, and the same as the others.
#include "src/cpu/simd_target.h"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <hwy/targets.h>
#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "src/base/error.h"
#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "tests/cpu/test_device.h"
#include "tests/support/plain_device.h"

namespace sluice::simd_target_test {
namespace {

constexpr Vec3i kDims{21, 18, 16};

// Smooth and noisy places; of floats some that are no number.
ChunkTexelsPtr texelsOf(DeviceType type) {
  std::vector<std::byte> bytes(static_cast<size_t>(volume(kDims)) * bytesPerVoxel(type));
  uint32_t state = 3;
  for (size_t i = 0; i < static_cast<size_t>(volume(kDims)); ++i) {
    state = state * 1664525U + 1013904223U;
    const auto x = static_cast<int>(i % 21), y = static_cast<int>(i / 21 % 18);
    int value = (x * 9 + y * 5) % 256;
    if ((state >> 24) > 200) value = static_cast<int>(state >> 16 & 255);
    visitDeviceType(type, [&](auto tag) {
      auto texel = static_cast<decltype(tag)>(value);
      if constexpr (std::is_same_v<decltype(tag), float>)
        if ((state >> 24) < 4) texel = kNotANumber;
      std::memcpy(bytes.data() + i * sizeof(texel), &texel, sizeof(texel));
    });
  }
  return chunkTexels(kDims, type, bytes);
}

// The same texels between two pages that nobody may touch, right behind the first or right before
// the last.
enum class Beside { kPageBefore, kPageBehind };
ChunkTexelsPtr guarded(const ChunkTexels& chunk, Beside beside) {
  const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  const size_t room = (chunk.byte_count + page - 1) / page * page, whole = room + 2 * page;
  void* mapped = mmap(nullptr, whole, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  SLUICE_CHECK(mapped != MAP_FAILED);
  auto* memory = static_cast<std::byte*>(mapped);
  std::byte* texels = memory + page + (beside == Beside::kPageBefore ? 0 : room - chunk.byte_count);
  std::copy_n(chunk.bytes.get(), chunk.byte_count, texels);
  SLUICE_CHECK_EQ(mprotect(memory, page, PROT_NONE), 0);
  SLUICE_CHECK_EQ(mprotect(memory + page + room, page, PROT_NONE), 0);
  auto result = std::make_shared<ChunkTexels>(chunk);
  result->bytes = std::shared_ptr<std::byte[]>(
      texels, [memory, whole](std::byte* /*texels*/) { munmap(memory, whole); });
  return result;
}

FrameSetup setupOf(DeviceType type, Projection projection, Mode mode) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.spacing = {1, 1.2, 0.9};
  FrameOptions options;
  options.camera.projection = projection;
  options.camera.azimuth_deg = 33;
  options.camera.elevation_deg = 21;
  options.size = {67, 59};  // neither a multiple of a tile nor of a packet
  options.step_vox = 0.7;
  options.mode = mode;
  const TransferFunction transfer{
      {{0, {0.2, 0.3, 0.9}}, {255, {1, 0.6, 0.1}}}, {{0, 0}, {40, 0}, {200, 0.2}, {255, 0.3}}, "t"};
  const ValueMap map = deviceMap(layout);
  FrameSetup setup = frameSetup(resolve(options, layout), layout,
                                OpacityTable(transfer, map, {0, 255}), map, options);
  setup.type = type;
  return setup;
}

// The volume as boxes of one cell and more, front to back for that view: with a margin of just a
// texel, of many, and without.
std::vector<BoxDraw> boxesOf(const FrameSetup& setup) {
  const Vec3d way = setup.rays.step0 + setup.rays.step_dx * 33 + setup.rays.step_dy * 30;
  std::vector<BoxDraw> boxes;
  const auto cuts = [&](int axis) {
    const int64_t last = kDims[axis] - 1;
    std::vector<std::pair<int64_t, int64_t>> parts{
        {0, 1}, {1, 4}, {4, 9}, {9, last - 1}, {last - 1, last}};
    if (way[axis] < 0) std::reverse(parts.begin(), parts.end());
    return parts;
  };
  for (const auto& [z_lo, z_hi] : cuts(2))
    for (const auto& [y_lo, y_hi] : cuts(1))
      for (const auto& [x_lo, x_hi] : cuts(0)) {
        BoxDraw box;
        box.chunk = 1;
        box.cells = {{x_lo, y_lo, z_lo}, {x_hi, y_hi, z_hi}};
        boxes.push_back(box);
      }
  return boxes;
}

Picture drawOn(Device& device, const FrameSetup& setup, ChunkTexelsPtr texels,
               uint64_t* samples = nullptr) {
  device.makeResident(1, std::move(texels));
  const std::vector<BoxDraw> boxes = boxesOf(setup);
  device.beginFrame(setup);
  device.draw(boxes);
  Picture picture = device.endFrame();
  if (samples != nullptr) *samples = device.countSamples(boxes);
  device.evict(1);
  return picture;
}

// The most that a channel differs, in 1/255, and how many pixels by more than 2.
struct Differences {
  double most = 0;
  int over = 0;
};
Differences differences(const Picture& a, const Picture& b) {
  Differences found;
  for (size_t i = 0; i < a.rgba.size(); i += 4) {
    double most = 0;
    for (size_t c = 0; c < 4; ++c)
      most = std::max(most, 255.0 * std::abs(a.rgba[i + c] - b.rgba[i + c]));
    found.most = std::max(found.most, most);
    found.over += most > 2 ? 1 : 0;
  }
  return found;
}

double shownShare(const Picture& picture) {
  int shown = 0;
  for (size_t i = 3; i < picture.rgba.size(); i += 4) shown += picture.rgba[i] > 0.02F ? 1 : 0;
  return 4.0 * shown / static_cast<double>(picture.rgba.size());
}

void change(FrameSetup& setup, const std::function<void(LookUp&)>& by) {
  LookUp look_up = *setup.look_up;
  by(look_up);
  setup.look_up = std::make_shared<const LookUp>(std::move(look_up));
}

struct Case {
  const char* name;
  FrameSetup setup;
};
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Projection projection : {Projection::kOrtho, Projection::kPerspective}) {
    for (const DeviceType type : {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32})
      all.push_back({"composite", setupOf(type, projection, Mode::kComposite)});
    Case next{"lit", setupOf(DeviceType::kU8, projection, Mode::kComposite)};
    next.setup.lit = true;
    all.push_back(next);
    next = {"lit floats", setupOf(DeviceType::kF32, projection, Mode::kComposite)};
    next.setup.lit = true;
    next.setup.lighting.shininess = 7.5;
    all.push_back(next);
    next = {"modulated", setupOf(DeviceType::kU16, projection, Mode::kComposite)};
    change(next.setup, [](LookUp& look_up) {
      look_up.magnitudes = {0, 10, 40};
      look_up.factors = {0.1F, 0.5F, 1};
    });
    all.push_back(next);
    next = {"interpolated look-up", setupOf(DeviceType::kF32, projection, Mode::kComposite)};
    change(next.setup, [](LookUp& look_up) { look_up.interpolates = true; });
    all.push_back(next);
    next = {"labels", setupOf(DeviceType::kU8, projection, Mode::kComposite)};
    change(next.setup, [](LookUp& look_up) { look_up.labels = true; });
    all.push_back(next);
    next = {"ends early, with depth", setupOf(DeviceType::kU8, projection, Mode::kComposite)};
    next.setup.opacity_threshold = 0.7;
    next.setup.with_depth = true;
    all.push_back(next);
    next = {"clip planes", setupOf(DeviceType::kU8, projection, Mode::kComposite)};
    next.setup.clip_planes = {{{1, 0.2, 0}, 12.3}, {{-0.3, 0, -1}, -3.1}};
    all.push_back(next);
    next = {"maximum", setupOf(DeviceType::kU8, projection, Mode::kMip)};
    all.push_back(next);
    next = {"minimum of floats", setupOf(DeviceType::kF32, projection, Mode::kMinip)};
    all.push_back(next);
    next = {"average", setupOf(DeviceType::kU16, projection, Mode::kAverage)};
    all.push_back(next);
  }
  return all;
}

TEST(SimdTargetTest, everyTargetDrawsTheSameCountsTheSameAndIsRight) {
  for (const Case& each : cases()) {
    PlainDevice plain;
    uint64_t expected_samples = 0;
    const Picture expected =
        drawOn(plain, each.setup, texelsOf(each.setup.type), &expected_samples);
    EXPECT_GT(shownShare(expected), 0.1) << each.name;
    std::optional<Picture> first;
    for (const SimdTarget target : simdTargets()) {
      SCOPED_TRACE(fmt::format("{}, {}, projection {}", each.name, name(target),
                               static_cast<int>(each.setup.projection)));
      TestCpuDevice device(target);
      EXPECT_NE(std::string(device.renderer()).find(name(target)), std::string::npos);
      uint64_t samples = 0;
      const Picture picture = drawOn(device, each.setup, texelsOf(each.setup.type), &samples);
      // A pixel may differ if rounding decides on a step of what is visible, or between labels.
      const Differences from_plain = differences(picture, expected);
      EXPECT_LE(from_plain.over, picture.width * picture.height / 100) << from_plain.most;
      EXPECT_NEAR(static_cast<double>(samples), static_cast<double>(expected_samples),
                  0.001 * static_cast<double>(expected_samples));
      if (!first) first = picture;
      const Differences from_first = differences(picture, *first);
      EXPECT_LE(from_first.over, picture.width * picture.height / 500) << from_first.most;
      ASSERT_EQ(picture.depth.size(), expected.depth.size());
      int far = 0;
      for (size_t i = 0; i < picture.depth.size(); ++i)
        far += expected.rgba[4 * i + 3] > 0.01F &&
                       !(std::abs(picture.depth[i] - expected.depth[i]) < 0.05)
                   ? 1
                   : 0;
      EXPECT_LE(far, picture.width * picture.height / 500);
    }
  }
}

// Sanitizers do not see the reads of vector loads.
TEST(SimdTargetTest, nothingBesideAChunkIsRead) {
  for (const Case& each : cases())
    for (const SimdTarget target : simdTargets()) {
      SCOPED_TRACE(fmt::format("{}, {}", each.name, name(target)));
      TestCpuDevice device(target);
      const ChunkTexelsPtr texels = texelsOf(each.setup.type);
      const Picture expected = drawOn(device, each.setup, texels);
      for (const Beside beside : {Beside::kPageBefore, Beside::kPageBehind})
        EXPECT_EQ(drawOn(device, each.setup, guarded(*texels, beside)).rgba, expected.rgba);
    }
}

// The least that there are: a cell and little more.
TEST(SimdTargetTest, tinyChunksAreReadWithinTheirBytes) {
  for (const SimdTarget target : simdTargets())
    for (const DeviceType type : {DeviceType::kU8, DeviceType::kU16, DeviceType::kF32})
      for (const Vec3i dims : {Vec3i{2, 2, 2}, {3, 2, 2}, {2, 3, 2}, {2, 2, 3}, {2, 5, 3}}) {
        SCOPED_TRACE(
            fmt::format("{} {} {} {} {}", name(target), name(type), dims.x, dims.y, dims.z));
        std::vector<std::byte> bytes(static_cast<size_t>(volume(dims)) * bytesPerVoxel(type));
        for (size_t i = 0; i < static_cast<size_t>(volume(dims)); ++i)
          visitDeviceType(type, [&](auto tag) {
            const auto texel = static_cast<decltype(tag)>(200);
            std::memcpy(bytes.data() + i * sizeof(texel), &texel, sizeof(texel));
          });
        FrameSetup setup = setupOf(type, Projection::kOrtho, Mode::kComposite);
        BoxDraw box;
        box.chunk = 1;
        box.cells = {{8, 8, 8}, {9, 9, 9}};
        box.texels.offset = {-8, -8, -8};
        for (const Beside beside : {Beside::kPageBefore, Beside::kPageBehind}) {
          TestCpuDevice device(target);
          device.makeResident(1, guarded(*chunkTexels(dims, type, bytes), beside));
          for (const bool lit : {false, true}) {
            setup.lit = lit;
            device.beginFrame(setup);
            device.draw({&box, 1});
            const Picture picture = device.endFrame();
            float most = 0;
            for (size_t i = 3; i < picture.rgba.size(); i += 4)
              most = std::max(most, picture.rgba[i]);
            EXPECT_GT(most, 0.1F);  // every sample sees the value of all texels
            EXPECT_LT(most, 0.6F);
          }
        }
      }
}

#if defined(__x86_64__)
// Builds for sanitizers have the plain target alone.
TEST(SimdTargetTest, thoseThatWorkAreThoseThatHighwayFinds) {
  const auto targets = simdTargets();
  const std::string_view compiled = SLUICE_KERNEL_SETS;
  for (const auto& [target, bit, set] : {std::tuple{SimdTarget::kSse4, HWY_SSE4, "SSE4"},
                                         {SimdTarget::kAvx2, HWY_AVX2, "AVX2"},
                                         {SimdTarget::kAvx512, HWY_AVX3, "AVX3"}})
    if (targets.size() > 1 && compiled.find(set) != std::string_view::npos) {
      const bool works = std::ranges::find(targets, target) != targets.end();
      EXPECT_EQ(works, (hwy::SupportedTargets() & bit) != 0) << name(target);
    }
}
#endif

TEST(SimdTargetTest, targetsHaveNamesAndTheBestIsTheLast) {
  const auto targets = simdTargets();
  ASSERT_FALSE(targets.empty());
  EXPECT_STREQ(kernelsOf(SimdTarget::kAuto).name, kernelsOf(targets.back()).name);
  for (const SimdTarget target : targets) EXPECT_EQ(kernelsOf(target).name, name(target));
}

}  // namespace
}  // namespace sluice::simd_target_test
