#include "cache/model/page_geometry.h"

#include <gtest/gtest.h>

#include "src/base/error.h"

namespace sluice {
namespace {

TEST(PageGeometry, countsWholePagesOfAChunk) {
  const PageGeometry octane;  // 32x64x2
  EXPECT_EQ(octane.pageGridOf({64, 64, 64}), (Vec3i{2, 1, 32}));
  EXPECT_EQ(octane.pagesOf({64, 64, 64}), 64);
  EXPECT_EQ(octane.pagesOf({64, 64, 3}), 4);
  EXPECT_EQ(octane.pagesOf({1, 1, 1}), 1);
  EXPECT_EQ(octane.pagesOf({64, 64, 0}), 0);
}

TEST(PageGeometry, namedMachinesAreWhatTheirMakersSay) {
  // Tong, section 4: a page is 4 KiB, the cache 128x128x64 voxels and holds 2x2 blocks of 64^3.
  const PageConfiguration* octane = findPageConfiguration("octane");
  ASSERT_NE(octane, nullptr);
  EXPECT_EQ(octane->geometry.pageBytes(), 4096);
  EXPECT_EQ(octane->geometry.cacheBytes(), 128 * 128 * 64);
  EXPECT_EQ(octane->geometry.pagesOf({64, 64, 64}) * 4, octane->geometry.pages);
  EXPECT_EQ(findPageConfiguration("octane-4mb")->geometry.cacheBytes(), 4 << 20);
  for (const char* sparse : {"sparse-8", "sparse-16", "sparse-32"})
    EXPECT_EQ(findPageConfiguration(sparse)->geometry.pageBytes(), 65536) << sparse;
  for (const PageConfiguration& c : pageConfigurations())
    EXPECT_NO_THROW(validate(c.geometry, c.name));
  EXPECT_EQ(findPageConfiguration("onyx"), nullptr);
}

TEST(PageGeometry, parsesAndPrintsPageSizes) {
  EXPECT_EQ(parsePageSize("64x32x32"), (Vec3i{64, 32, 32}));
  EXPECT_EQ(printPageSize({64, 32, 32}), "64x32x32");
  for (const char* bad : {"", "64", "64x32", "64x32x", "64x32x33", "0x32x32", "-2x2x2",
                          "64x32x32x2", "64x32x32 ", "2097152x1x1", "99999999999999999999x1x1"})
    EXPECT_EQ(parsePageSize(bad), std::nullopt) << bad;
}

TEST(PageGeometry, rejectsWhatIsNoPage) {
  EXPECT_THROW(validate({{3, 4, 4}, 1, 4}, "--page"), Error);
  EXPECT_THROW(validate({{4, 4, 4}, 0, 4}, "--page"), Error);
  EXPECT_THROW(validate({{4, 4, 4}, 1, 0}, "--page"), Error);
  EXPECT_THROW(validate({{1 << 20, 1 << 20, 1 << 20}, 16, 4}, "--page"), Error);
}

}  // namespace
}  // namespace sluice
