// A renderer of two volumes that are blended unless a picture has shadows: what it keeps in memory
// from picture to picture, and after one that finds no memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/library/library_support.h"
#include "tests/support/error_of.h"

namespace sluice {
namespace {

using testing::HasSubstr;

const VolumeOptions kOver{.over = "synth:parts,dims=48x40x36"};

PictureOptions shadowed() {
  PictureOptions picture = kSmall;
  picture.lighting.shadows = 0.5;
  return picture;
}

TEST(Combining, editsOfTheLookKeepTheMemoryOfPicturesWithShadows) {
  const Volume volume(kShells, kOver);
  Renderer renderer(volume, {.threshold = 90});
  renderer.draw(shadowed());
  const uint64_t requests = renderer.report().texture_cache.requests;
  const uint64_t loads = renderer.report().texture_cache.loads;
  ASSERT_GT(loads, 0U);
  renderer.setLook({.threshold = 90, .opacity = 0.2});
  EXPECT_TRUE(renderer.shownLook().blends) << "without light that looks around";
  const Image edited = renderer.draw(shadowed());
  EXPECT_EQ(renderer.report().texture_cache.loads, loads);
  EXPECT_GT(renderer.report().texture_cache.requests, requests);
  EXPECT_FALSE(renderer.shownLook().blends);
  EXPECT_THAT(renderer.report().why_added, HasSubstr("added, not blended: --combine blend knows"));
  EXPECT_THAT(renderer.lookWarnings(), testing::Contains(renderer.report().why_added));
  Renderer other(volume, {.threshold = 90, .opacity = 0.2});
  EXPECT_EQ(edited.rgba, other.draw(shadowed()).rgba);
  EXPECT_GT(visiblePixels(edited.toRgba8()), 0U);
}

TEST(Combining, whatIsNotDrawnChangesNoMemory) {
  const Volume volume(kShells, kOver);
  Renderer renderer(volume, {.threshold = 90});
  const Image blended = renderer.draw(kSmall);
  const uint64_t loads = renderer.report().texture_cache.loads;
  ASSERT_GT(loads, 0U);
  renderer.plan(shadowed());
  renderer.sampling(shadowed());
  EXPECT_EQ(renderer.report().texture_cache.loads, loads);
  EXPECT_EQ(renderer.draw(kSmall).rgba, blended.rgba);
  EXPECT_EQ(renderer.report().texture_cache.loads, loads);
}

TEST(Combining, aVolumeOfAnotherTypeHasTheBlocksOfTheFirst) {
  const Volume volume("synth:shells,dims=48x40x36,type=u16", kOver);
  EXPECT_TRUE(Renderer(volume).shownLook().blends);
}

// The least memory of a renderer, found by bisection.
uint64_t leastMemory(const Volume& volume) {
  uint64_t too_little = 1, enough = uint64_t{1} << 30;
  while (enough - too_little > 4096) {
    const uint64_t middle = too_little + (enough - too_little) / 2;
    try {
      const Renderer renderer(volume, {}, {.memory_bytes = middle});
      enough = middle;
    } catch (const Error&) {
      too_little = middle;
    }
  }
  return enough;
}

void expectUsableWithoutMemoryForShadows(const VolumeOptions& options) {
  const Volume volume(kShells, options);
  Renderer renderer(volume, {}, {.memory_bytes = leastMemory(volume)});
  const Image expected = renderer.draw(kSmall);
  for (int time = 0; time < 2; ++time)
    EXPECT_THAT(errorOf([&] { renderer.draw(shadowed()); }), HasSubstr("memory"));
  EXPECT_GT(renderer.report().texture_cache.budget_bytes, 0U);
  EXPECT_EQ(renderer.draw(kSmall).rgba, expected.rgba);
  EXPECT_THAT(errorOf([&] { renderer.draw(shadowed()); }), HasSubstr("memory"));
  renderer.setLook({.opacity = 0.2});
  EXPECT_NE(renderer.draw(kSmall).rgba, expected.rgba);
}

TEST(Combining, aPictureWithoutMemoryLeavesTheRendererUsable) {
  expectUsableWithoutMemoryForShadows({});
}

TEST(Combining, aPictureOfTwoVolumesWithoutMemoryLeavesTheRendererUsable) {
  expectUsableWithoutMemoryForShadows(kOver);
}

}  // namespace
}  // namespace sluice
