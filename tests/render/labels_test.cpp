// Labels against the reference.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "src/classify/transfer/label_table.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/index_space.h"
#include "tests/gl/test_device.h"
#include "tests/render/render_scene.h"
#include "tests/support/memory_source.h"

namespace sluice {
namespace {

// Software GL against a renderer in double precision.
constexpr double kOfReference = 1.5;

class LabelsTest : public RenderTest {};

// Balls that touch, of numbers that are far apart and in no order.
std::unique_ptr<MemorySource> things() {
  return makeMemorySource<uint8_t>(Vec3i{30, 28, 26}, [](auto x, auto y, auto z) {
    const auto inside = [&](int64_t cx, int64_t cy, int64_t cz, int64_t r) {
      return (x - cx) * (x - cx) + (y - cy) * (y - cy) + (z - cz) * (z - cz) < r * r;
    };
    return inside(9, 10, 12, 7) ? 200 : inside(18, 10, 12, 6) ? 3 : inside(15, 19, 14, 7) ? 90 : 0;
  });
}

TEST_F(LabelsTest, labelsGiveTheReferencePicture) {
  const auto source = things();
  const TransferFunction transfer = labelsTransfer(labelStyles({0, 3, 90, 200}, 0));
  for (const bool lit : {false, true})
    for (const int64_t block : {8, 32}) {
      RenderScene scene(device(), *source, transfer, {.block_vox = block, .lit = lit});
      for (const Projection projection : kProjections)
        for (const double step : {1.0, 0.5}) {
          SCOPED_TRACE(fmt::format("lit {} block {} projection {} step {}", lit, block,
                                   static_cast<int>(projection), step));
          FrameOptions options = obliqueView(projection);
          options.step_vox = step;
          EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
        }
    }
}

// Labels that only floats hold, and that 2^16 entries do not tell apart.
TEST_F(LabelsTest, labelsFarApartGiveTheReferencePicture) {
  for (const float greatest : {70000.0F, 1048575.0F}) {
    SCOPED_TRACE(greatest);
    const auto numbers = things();
    const auto source =
        makeMemorySource<float>(numbers->layout().dims, [&](auto x, auto y, auto z) -> float {
          std::array<std::byte, 1> voxel{};
          numbers->readRegion(0, {{x, y, z}, {x + 1, y + 1, z + 1}}, voxel);
          const auto number = std::to_integer<int>(voxel[0]);
          return number == 200 ? greatest : number == 90 ? 17 : number == 3 ? 1 : 0;
        });
    RenderScene scene(device(), *source, labelsTransfer(labelStyles({0, 1, 17, greatest}, 0)),
                      {.block_vox = 16, .lit = true});
    const FrameOptions options = obliqueView(Projection::kOrtho);
    EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)));
  }
}

// The part of a grey surface's brightness that lighting.h gives a normal in camera space.
double brightnessOf(const Lighting& lighting, Vec3d normal, double grey) {
  double diffuse = lighting.ambient, specular = 0;
  for (const Light& light : lighting.lights) {
    const Vec3d halfway = normalized(light.toward + Vec3d{0, 0, 1});
    diffuse += lighting.diffuse * light.strength * std::abs(dot(normal, light.toward));
    specular += lighting.specular * light.strength *
                std::pow(std::abs(dot(normal, halfway)), lighting.shininess);
  }
  return grey * diffuse + specular;
}

// A ball in eight parts of any numbers looks like a sphere: neither seams nor the steps of its
// voxels show much. With central differences of the numbers it is off by 0.037 on average.
TEST_F(LabelsTest, labelsOfABallAreLitLikeASphere) {
  constexpr double kRadius = 22, kGrey = 0.5;
  constexpr double kMiddle = 25.3;
  const std::array numbers{1, 200, 7, 120, 3, 250, 60, 61};
  const auto source = makeMemorySource<uint8_t>(Vec3i{52, 52, 52}, [&](auto x, auto y, auto z) {
    const Vec3d p = toDouble(Vec3i{x, y, z}) - Vec3d{kMiddle, kMiddle, kMiddle};
    const size_t part = (p.x > 0 ? 1U : 0U) + (p.y > 0 ? 2U : 0U) + (p.z > 0 ? 4U : 0U);
    return length(p) < kRadius ? numbers[part] : 0;
  });
  std::vector<LabelStyle> styles{{0, {0, 0, 0}, 0}};
  for (const int number : numbers)
    styles.push_back({static_cast<double>(number), {kGrey, kGrey, kGrey}, 1});
  std::ranges::sort(styles, {}, &LabelStyle::label);
  RenderScene scene(device(), *source, labelsTransfer(styles), {.block_vox = 16, .lit = true});
  FrameOptions options = obliqueView(Projection::kOrtho, {96, 96});
  options.step_vox = 0.25;
  const FloatPicture drawn = scene.draw(options);
  const View view = resolve(options, source->layout());
  const Vec3d center = worldFromIndex(source->layout(), {kMiddle, kMiddle, kMiddle});
  double sum = 0;
  int pixels = 0;
  for (int j = 0; j < 96; ++j)
    for (int i = 0; i < 96; ++i) {
      const double u = 2 * (i + 0.5) / 96 - 1, v = 1 - 2 * (j + 0.5) / 96;
      const Vec3d to = view.eye - center;
      const Vec3d n{(dot(to, view.right) + u * view.half_height) / kRadius,
                    (dot(to, view.up) + v * view.half_height) / kRadius, 0};
      const double toward = 1 - dot(n, n);
      if (toward < 0.1) continue;  // the rim
      const double expected = brightnessOf(options.lighting, {n.x, n.y, std::sqrt(toward)}, kGrey);
      sum += std::abs(drawn.at(i, j)[0] - expected);
      ++pixels;
    }
  EXPECT_GT(pixels, 1000);
  EXPECT_LT(sum / pixels, 0.02);
}

// Modes that show values take labels for numbers. Their table has more entries than a texture is
// wide, whatever the values are.
TEST_F(LabelsTest, labelsInModesOfValuesGiveTheReferencePicture) {
  const auto source = things();
  std::vector<LabelStyle> styles = labelStyles({0, 3, 90, 200}, 0);
  styles[2].opacity = 0;  // a hole in the table
  for (const Mode mode :
       {Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip, Mode::kDepthMip})
    for (const Projection projection : kProjections) {
      SCOPED_TRACE(fmt::format("mode {} projection {}", static_cast<int>(mode),
                               static_cast<int>(projection)));
      RenderScene scene(device(), *source, labelsTransfer(styles), {.block_vox = 8});
      FrameOptions options = obliqueView(projection);
      options.mode = mode;
      const FloatPicture drawn = scene.draw(options);
      EXPECT_GT(shownShare(drawn), 0.02);
      EXPECT_LT(shownShare(drawn), 0.5);
      const FloatPicture reference = scene.reference(options);
      if (mode != Mode::kDepthMip) {
        EXPECT_TRUE(within(kOfReference, drawn, reference));
        continue;
      }
      // A step of depth_code.h may be decided either way, which it is in three pixels.
      EXPECT_TRUE(within(6, drawn, reference));
      EXPECT_LE(compare(drawn, reference, kOfReference).pixels_over, 3);
    }
}

TEST_F(LabelsTest, labelsShowNoColourButTheirOwn) {
  const auto source = things();
  const TransferFunction transfer = labelsTransfer(labelStyles({0, 3, 90, 200}, 0));
  RenderScene scene(device(), *source, transfer, {.block_vox = 8});
  FrameOptions options = obliqueView(Projection::kOrtho, {128, 128});
  options.step_vox = 0.25;
  const FloatPicture drawn = scene.draw(options);
  std::array<int, 3> seen{};
  for (int j = 0; j < 128; ++j)
    for (int i = 0; i < 128; ++i) {
      const auto pixel = drawn.at(i, j);
      if (pixel[3] < 0.5) continue;
      ASSERT_GT(pixel[3], 0.999) << "nothing is between a thing and nothing";
      bool known = false;
      for (size_t label = 0; label < 3; ++label) {
        const Vec3d rgb = labelColor(std::array{3, 90, 200}[label]);
        const double off = std::max(
            {std::abs(rgb.x - pixel[0]), std::abs(rgb.y - pixel[1]), std::abs(rgb.z - pixel[2])});
        if (off < 1.0 / 255) {
          known = true;
          ++seen[label];
        }
      }
      ASSERT_TRUE(known) << i << ", " << j;
    }
  for (const int pixels : seen) EXPECT_GT(pixels, 100);
}

// Cubes of labels from all over 16 bits.
std::unique_ptr<MemorySource> manyLabels() {
  return makeMemorySource<uint16_t>(Vec3i{34, 30, 26}, [](int64_t x, int64_t y, int64_t z) {
    const int64_t cube = (x / 5) + 7 * (y / 5) + 49 * (z / 5);
    return static_cast<double>(cube % 4 == 0 ? 0 : cube * 40503 % 65536);
  });
}

TEST_F(LabelsTest, eachOfManyLabelsHasItsOwnOpacityAndColour) {
  const auto source = manyLabels();
  std::vector<LabelStyle> styles;
  for (int i = 0; i < 65536; ++i)
    styles.push_back({static_cast<double>(i),
                      {i % 256 / 255.0, i / 256 / 255.0, i % 7 / 6.0},
                      i == 0 ? 0 : std::array{0.0, 0.15, 1.0}[static_cast<size_t>(i % 3)]});
  for (const bool lit : {false, true}) {
    RenderScene scene(device(), *source, labelsTransfer(styles), {.block_vox = 8, .lit = lit});
    for (const Projection projection : kProjections) {
      const FrameOptions options = obliqueView(projection, {64, 60});
      EXPECT_TRUE(within(kOfReference, scene.draw(options), scene.reference(options)))
          << lit << ", " << static_cast<int>(projection);
    }
  }
}

TEST_F(LabelsTest, blocksOfLabelsThatDoNotShowAreNotDrawn) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{57, 17, 17}, [](int64_t x, int64_t, int64_t) {
    return x < 30 ? 4.0 : x < 44 ? 5 : 6;
  });
  for (const double shown : {4.0, 5.0, 6.0}) {
    auto styles = labelStyles({0, 4, 5, 6}, 0);
    for (LabelStyle& style : styles) style.opacity = style.label == shown ? 0.5 : 0;
    RenderScene scene(device(), *source, labelsTransfer(styles), {.block_vox = 8});
    const Frame frame = scene.frame(obliqueView(Projection::kOrtho, {64, 60}));
    ASSERT_FALSE(frame.blocks->blocks.empty());
    for (const ObjectBlock& block : frame.blocks->blocks) {
      EXPECT_GE(block.cells.hi.x, shown == 4 ? 0 : shown == 5 ? 30 : 44) << shown;
      EXPECT_LE(block.cells.lo.x, shown == 4 ? 29 : shown == 5 ? 43 : 57) << shown;
    }
  }
}

}  // namespace
}  // namespace sluice
