// Kinds of voxels and looks: every voxel type, scale and offset, NaN and infinities, and transfer
// functions of every shape.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "src/classify/transfer/transfer_makers.h"
#include "tests/render/render_scene.h"
#include "tests/support/random_volume.h"

namespace sluice::values_test {
namespace {

constexpr double kOfReference = 2, kOfPlain = 1;
constexpr Vec3i kDims{30, 27, 24};

// 0..1, smooth, without symmetry.
double wave(int64_t x, int64_t y, int64_t z) {
  const auto turn = [](int64_t i, double period) {
    return std::sin(static_cast<double>(i) / period);
  };
  return 0.5 + 0.2 * turn(x, 4) + 0.15 * turn(y + 3, 3) + 0.15 * turn(z + 1, 5);
}

template <class T>
std::unique_ptr<MemorySource> waves(ValueRange range, double scale = 1, double offset = 0) {
  VolumeLayout layout;
  layout.dims = kDims;
  layout.value_scale = scale;
  layout.value_offset = offset;
  return makeMemorySource<T>(layout, [&](int64_t x, int64_t y, int64_t z) {
    return range.lo + wave(x, y, z) * (range.hi - range.lo);
  });
}

// Opaque above the middle of the values, colours over all of them.
TransferFunction rampOver(ValueRange range) {
  const double middle = 0.5 * (range.lo + range.hi);
  return pointsTransfer("viridis", range, {{middle, 0}, {range.hi, 0.3}});
}

class ValuesTest : public RenderTest {
 protected:
  void expectRightPicture(VolumeSource& source, const TransferFunction& transfer,
                          const std::string& what, double least_shown = 0.05) {
    for (const bool lit : {false, true}) {
      SCOPED_TRACE(fmt::format("{}, lit {}", what, lit));
      RenderScene scene(device(), source, transfer, {.block_vox = 8, .lit = lit});
      FrameOptions options =
          obliqueView(lit ? Projection::kPerspective : Projection::kOrtho, {64, 60});
      const FloatPicture drawn = scene.draw(options);
      EXPECT_GE(shownShare(drawn), least_shown);
      EXPECT_TRUE(within(kOfReference, drawn, scene.reference(options)));
      options.algorithm = Algorithm::kConventional;
      EXPECT_TRUE(within(kOfPlain, drawn, scene.draw(options)));
    }
  }
  template <class T>
  void expectRightPicture(ValueRange range, const std::string& what) {
    const auto source = waves<T>(range);
    expectRightPicture(*source, rampOver(range), what);
  }
};

TEST_F(ValuesTest, everyVoxelTypeKeepsItsRange) {
  expectRightPicture<uint8_t>({0, 255}, "u8");
  expectRightPicture<int8_t>({-128, 127}, "i8");
  expectRightPicture<uint16_t>({0, 65535}, "u16");
  expectRightPicture<uint16_t>({1000, 1300}, "u16 of few values");
  expectRightPicture<int16_t>({-32768, 32767}, "i16");
  expectRightPicture<int16_t>({-1000, 3000}, "i16, Hounsfield");
  expectRightPicture<uint32_t>({0, 4294967295.0}, "u32");
  expectRightPicture<int32_t>({-2147483648.0, 2147483647.0}, "i32");
  expectRightPicture<float>({-1, 1}, "f32");
  expectRightPicture<float>({1e-20, 3e-20}, "tiny f32");
  expectRightPicture<float>({-1e20, 1e20}, "huge f32");
  expectRightPicture<double>({-5, 12}, "f64");
}

TEST_F(ValuesTest, scaleAndOffsetApplyToValues) {
  for (const double scale : {0.01, 3.0, -0.5}) {
    const double offset = 7;
    const ValueRange values{std::min(255 * scale, 0.0) + offset,
                            std::max(255 * scale, 0.0) + offset};
    expectRightPicture(*waves<uint8_t>({0, 255}, scale, offset), rampOver(values),
                       fmt::format("u8 times {}", scale));
    const ValueRange signed_values{std::min(-500 * scale, 500 * scale) + offset,
                                   std::max(-500 * scale, 500 * scale) + offset};
    expectRightPicture(*waves<int16_t>({-500, 500}, scale, offset), rampOver(signed_values),
                       fmt::format("i16 times {}", scale));
  }
}

TEST_F(ValuesTest, negativeScaleTurnsMipIntoTheGreatestValue) {
  const auto source = waves<uint8_t>({0, 255}, -1, 255);
  const TransferFunction transfer = pointsTransfer("viridis", {0, 255}, {{0, 1}});
  RenderScene scene(device(), *source, transfer, {.block_vox = 8});
  for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage}) {
    FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
    options.mode = mode;
    EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)))
        << static_cast<int>(mode);
  }
}

TEST_F(ValuesTest, transferFunctionsOfEveryShape) {
  const auto source = waves<uint8_t>({0, 255});
  const std::vector<ColorPoint> colors = {{0, {0, 0, 1}}, {128, {0, 1, 0}}, {255, {1, 0, 0}}};
  const auto expectRight = [&](std::vector<OpacityPoint> opacities, const std::string& what,
                               double least_shown = 0.05) {
    expectRightPicture(*source, {colors, std::move(opacities), what}, what, least_shown);
  };
  expectRight({{100, 0}, {110, 0.2}, {120, 0}}, "a band");
  expectRight({{60, 0}, {65, 0.1}, {70, 0}, {170, 0}, {175, 0.3}, {180, 0}}, "two bands");
  expectRight({{128, 0}, {128, 0.1}}, "a step up");
  expectRight({{128, 0.1}, {128, 0}}, "a step down");
  expectRight({{0, 1}}, "everything opaque");
  expectRight({{128, 0}, {160, 1}}, "an opaque end");
  expectRight({{0, 0}}, "nothing visible", 0);
  expectRight({{300, 0}, {400, 1}}, "nothing visible in the range", 0);
  expectRight({{-100, 0.3}, {-50, 0}}, "only values below the range", 0);
  expectRight({{0, 1e-4}}, "a breath of everything", 0);
}

TEST_F(ValuesTest, nothingVisibleGivesAnEmptyPictureAtNoCost) {
  const auto source = waves<uint8_t>({0, 255});
  RenderScene scene(device(), *source, {{{0, {1, 1, 1}}}, {{0, 0}}, "nothing"});
  const Frame frame = scene.frame(obliqueView(Projection::kOrtho));
  EXPECT_EQ(frame.report.uploaded_bytes, 0U);
  EXPECT_EQ(frame.report.blocks.grey + frame.report.blocks.black, 0);
  for (const float v : frame.picture.rgba) ASSERT_EQ(v, 0);
}

TEST_F(ValuesTest, whiteNoiseIsTheWorstCase) {
  const auto source = makeWhiteNoise({26, 24, 22}, VoxelType::kU8, 5);
  expectRightPicture(*source, rampOver({0, 255}), "u8");
  const auto floats = makeWhiteNoise({26, 24, 22}, VoxelType::kF32, 6);
  expectRightPicture(*floats, rampOver({0, 1}), "f32");
}

TEST_F(ValuesTest, aVolumeOfOneValue) {
  for (const double opacity : {0.0, 0.1, 1.0}) {
    const auto source = makeMemorySource<float>(kDims, [](auto...) { return 0.25; });
    expectRightPicture(*source, {{{0, {0.2, 0.4, 0.6}}}, {{0, opacity}}, "one"},
                       fmt::format("opacity {}", opacity), 0);
  }
}

// Whatever touches a voxel that is no number shows nothing, as in the reference.
TEST_F(ValuesTest, notANumberIsTransparent) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto source = makeMemorySource<float>(kDims, [&](int64_t x, int64_t y, int64_t z) {
    return (x / 4 + y / 5 + z / 6) % 3 == 0 ? nan : static_cast<float>(wave(x, y, z));
  });
  expectRightPicture(*source, rampOver({0, 1}), "low values transparent");
  // A mask of NaN is no low value, even if low values are visible.
  TransferFunction low = rampOver({0, 1});
  low.opacities = {{0.3, 0.3}, {0.5, 0}};
  expectRightPicture(*source, low, "low values opaque");
  RenderScene scene(device(), *source, low, {.block_vox = 8});
  for (const Mode mode : {Mode::kMip, Mode::kMinip, Mode::kAverage}) {
    FrameOptions options = obliqueView(Projection::kOrtho, {64, 60});
    options.mode = mode;
    EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)))
        << static_cast<int>(mode);
  }
}

// A single infinite voxel spoils neither the others nor the table's resolution.
TEST_F(ValuesTest, infinityIsTheHighestValue) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float extreme : {infinity, -infinity}) {
    const auto source = makeMemorySource<float>(kDims, [&](int64_t x, int64_t y, int64_t z) {
      return x == 14 && y == 12 && z == 11 ? extreme : static_cast<float>(wave(x, y, z));
    });
    expectRightPicture(*source, rampOver({0, 1}), fmt::format("{}", extreme));
  }
}

// A fill value far off the data, as simulations write it where they know nothing.
TEST_F(ValuesTest, farOutlierDoesNotSpoilTheRest) {
  for (const float fill : {-9999.0F, 1e20F}) {
    const auto source = makeMemorySource<float>(kDims, [&](int64_t x, int64_t y, int64_t z) {
      return x < 8 && y < 9 ? fill : static_cast<float>(wave(x, y, z));
    });
    TransferFunction transfer = rampOver({0, 1});
    transfer.opacities.push_back({1.5, 0});
    expectRightPicture(*source, transfer, fmt::format("fill value {}", fill));
  }
}

}  // namespace
}  // namespace sluice::values_test
