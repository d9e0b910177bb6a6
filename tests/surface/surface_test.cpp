// Surfaces against analytic ones and against plain loops over all edges of a volume.
#include "src/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "src/surface/vertex_maker.h"
#include "tests/support/counting_source.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_source.h"
#include "tests/support/function_source.h"
#include "tests/support/random_volume.h"
#include "tests/surface/made_surface.h"

namespace sluice::surface_test {
namespace {

// The vertices by plain loops over all edges: positions in voxels, sorted.
template <class T>
std::vector<Triple> plainVertices(const MemorySource& source, double threshold) {
  const Vec3i dims = source.layout().dims;
  const auto* voxels = reinterpret_cast<const T*>(source.bytes().data());
  const auto at = [&](Vec3i p) {
    return static_cast<double>(voxels[(p.z * dims.y + p.y) * dims.x + p.x]);
  };
  std::vector<Triple> found;
  for (int64_t z = 0; z < dims.z; ++z)
    for (int64_t y = 0; y < dims.y; ++y)
      for (int64_t x = 0; x < dims.x; ++x)
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3i p{x, y, z};
          Vec3i q = p;
          if (++q[axis] == dims[axis] || (at(p) >= threshold) == (at(q) >= threshold)) continue;
          Vec3d place = toDouble(p);
          place[axis] +=
              std::clamp((threshold - at(p)) / (at(q) - at(p)), kLeastShare, 1 - kLeastShare);
          found.push_back(floatsOf(place));
        }
  std::ranges::sort(found);
  return found;
}
// Falls from 30 in the middle by 1 a voxel.
std::unique_ptr<MemorySource> ball(VolumeLayout layout) {
  return makeMemorySource<float>(layout, [=](auto x, auto y, auto z) {
    const Vec3d middle = toDouble(layout.dims - Vec3i{1, 1, 1}) / 2.0 + Vec3d{0.3, 0.1, -0.2};
    const Vec3d from = toDouble({x, y, z}) - middle;
    return 30 - length(from * layout.spacing);
  });
}

TEST(Surface, ofABallHasItsRadiusAndItsNormals) {
  VolumeLayout layout;
  layout.dims = {60, 62, 64};
  const auto source = ball(layout);
  const Made made = make(*source, {.threshold = 6});
  ASSERT_GT(made.mesh.vertices.size(), 1000U);
  const Vec3d middle = toDouble(layout.dims - Vec3i{1, 1, 1}) / 2.0 + Vec3d{0.3, 0.1, -0.2};
  double radius_error = 0, cosine = 1;
  for (size_t i = 0; i < made.mesh.vertices.size(); ++i) {
    const Vec3d from = made.mesh.position(i) - middle;
    radius_error = std::max(radius_error, std::abs(length(from) - 24));
    cosine = std::min(cosine, dot(from, made.mesh.normal(i)) / length(from));
  }
  EXPECT_LT(radius_error, 0.01);
  EXPECT_GT(cosine, std::cos(3.14159265 / 180));
  EXPECT_TRUE(openSides(made.mesh).empty());
  const double exact = 4.0 / 3 * 3.14159265 * 24 * 24 * 24;
  EXPECT_NEAR(enclosedVolume(made.mesh), exact, 0.005 * exact);  // outwards: above 0
}

TEST(Surface, liesInTheWorldOfTheHeader) {
  VolumeLayout layout;
  layout.dims = {60, 44, 36};
  layout.spacing = {1, 1.5, 2};
  layout.origin = {100, -50, 7};
  layout.axes = {{{0, 0.6, 0.8}, {1, 0, 0}, {0, 0.8, -0.6}}};
  for (const bool is_mirrored : {false, true}) {
    if (is_mirrored) layout.axes[2] = -layout.axes[2];
    const auto source = ball(layout);
    const Made made = make(*source, {.threshold = 6});
    Vec3d middle = layout.origin;
    const Vec3d at = toDouble(layout.dims - Vec3i{1, 1, 1}) / 2.0 + Vec3d{0.3, 0.1, -0.2};
    for (int a = 0; a < 3; ++a)
      middle = middle + layout.axes[static_cast<size_t>(a)] * (at[a] * layout.spacing[a]);
    for (size_t i = 0; i < made.mesh.vertices.size(); ++i) {
      const Vec3d from = made.mesh.position(i) - middle;
      ASSERT_NEAR(length(from), 24, 0.03);
      ASSERT_GT(dot(from, made.mesh.normal(i)) / length(from), std::cos(3.14159265 / 60));
    }
    EXPECT_GT(enclosedVolume(made.mesh), 50'000) << is_mirrored;
    EXPECT_TRUE(openSides(made.mesh).empty());
  }
}

template <class T>
class SurfaceOfType : public testing::Test {};
using Types = testing::Types<uint8_t, uint16_t, float>;
TYPED_TEST_SUITE(SurfaceOfType, Types);

// White noise has every case of the table, and every kind of face between pieces.
TYPED_TEST(SurfaceOfType, hasTheVerticesThatPlainLoopsFindAndNoCrack) {
  const auto source = makeWhiteNoise({70, 33, 29}, voxelTypeOf<TypeParam>(), 3);
  const double threshold = std::is_same_v<TypeParam, float>     ? 0.6
                           : std::is_same_v<TypeParam, uint8_t> ? 140
                                                                : 30'000;
  const Made made = make(*source, {.threshold = threshold, .block = 8});
  EXPECT_EQ(sortedPositions(made.mesh), plainVertices<TypeParam>(*source, threshold));
  expectVerticesOnce(made.mesh);
  // An open surface ends at the border of the volume alone.
  const Vec3d last = toDouble(source->layout().dims - Vec3i{1, 1, 1});
  for (const auto& [a, b] : openSides(made.mesh)) {
    bool is_at_border = false;
    for (int axis = 0; axis < 3; ++axis)
      for (const double border : {0.0, last[axis]})
        is_at_border = is_at_border || (made.mesh.position(a)[axis] == border &&
                                        made.mesh.position(b)[axis] == border);
    EXPECT_TRUE(is_at_border);
  }
}

TEST(Surface, isTheSameForAnyBlocksThreadsAndMemory) {
  const auto source = makeWhiteNoise({150, 40, 37}, VoxelType::kU8, 8);
  const Made whole = make(*source, {.threshold = 200, .block = 256, .threads = 1});
  const auto triangles = sortedTriangles(whole.mesh);
  for (const int64_t block : {8, 16, 32}) {
    const Made one = make(*source, {.threshold = 200, .block = block, .threads = 1});
    EXPECT_EQ(sortedTriangles(one.mesh), triangles) << block;
    expectVerticesOnce(one.mesh);
    for (const int threads : {2, 5})
      EXPECT_TRUE(make(*source, {.threshold = 200, .block = block, .threads = threads}).bytes ==
                  one.bytes)
          << block << " " << threads;
  }
  // Short pieces.
  const Made least = make(*source, {.threshold = 200, .block = 16, .memory_bytes = 6 << 20});
  EXPECT_EQ(sortedTriangles(least.mesh), triangles);
  // Fewer threads work if the memory is short, on the same pieces.
  for (const uint64_t mib : {6, 12, 24, 48}) {
    const auto bytesOf = [&](int threads) {
      return make(*source,
                  {.threshold = 200, .block = 16, .threads = threads, .memory_bytes = mib << 20})
          .bytes;
    };
    const auto one = bytesOf(1);
    for (const int threads : {2, 5}) EXPECT_TRUE(bytesOf(threads) == one) << mib << " " << threads;
  }
}

TEST(Surface, saysHowMuchMemoryItNeeds) {
  const auto source = makeWhiteNoise({150, 40, 37}, VoxelType::kU8, 8);
  const std::string line =
      errorOf([&] { make(*source, {.threshold = 200, .memory_bytes = 1 << 20}); });
  EXPECT_NE(line.find("needs at least"), std::string::npos) << line;
  EXPECT_NE(line.find("--memory"), std::string::npos) << line;
}

TEST(Surface, closedHasNoBorderAtAll) {
  const auto source = makeWhiteNoise({50, 24, 21}, VoxelType::kU8, 4);
  for (const double threshold : {0.0, 40.0, 200.0}) {
    const Made made = make(*source, {.threshold = threshold, .block = 8, .is_closed = true});
    EXPECT_TRUE(openSides(made.mesh).empty()) << threshold;
    expectVerticesOnce(made.mesh);
    EXPECT_GT(enclosedVolume(made.mesh), 0);
  }
  // All of the volume: its box.
  const Made box = make(*source, {.threshold = 0, .block = 8, .is_closed = true});
  EXPECT_NEAR(enclosedVolume(box.mesh), 49 * 23 * 20, 49 * 23 * 20 * 0.001);
}

TEST(Surface, ofACropEndsThereAndIsThePartOfTheWhole) {
  const auto source = makeWhiteNoise({60, 30, 28}, VoxelType::kU8, 6);
  const Box3 cells{{13, 5, 9}, {47, 22, 20}};
  const Made whole = make(*source, {.threshold = 128, .block = 8});
  const Made part = make(*source, {.threshold = 128, .block = 8, .cells = cells});
  const auto all = sortedTriangles(whole.mesh), some = sortedTriangles(part.mesh);
  EXPECT_TRUE(std::ranges::includes(all, some));
  const auto isIn = [&](const std::array<Triple, 3>& triangle) {
    for (const Triple& p : triangle)
      for (size_t a = 0; a < 3; ++a)
        if (p[a] < static_cast<float>(cells.lo[static_cast<int>(a)]) ||
            p[a] > static_cast<float>(cells.hi[static_cast<int>(a)]))
          return false;
    return true;
  };
  // Triangles within faces of the crop may belong to either side.
  const auto within = static_cast<size_t>(std::ranges::count_if(all, isIn));
  EXPECT_GE(within, some.size());
  EXPECT_LT(within - some.size(), some.size() / 20);
  const Made closed =
      make(*source, {.threshold = 128, .block = 8, .is_closed = true, .cells = cells});
  EXPECT_TRUE(openSides(closed.mesh).empty());
  expectVerticesOnce(closed.mesh);
}

TEST(Surface, readsOnlyBlocksThatItPassesThrough) {
  VolumeLayout layout;
  layout.dims = {120, 120, 120};
  const auto source = ball(layout);
  CountingSource counting(*source);
  const Made made = makeFrom(*source, counting, {.threshold = 20, .block = 16});
  EXPECT_GT(made.report.blocks_read, 0);
  EXPECT_LT(made.report.blocks_read, made.report.blocks / 8);
  int64_t voxels = 0;
  for (const CountingSource::Read& read : counting.reads()) {
    voxels += read.box.count();
    // In the smallest box around the ball, and one block and a ghost layer more.
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(read.box.lo[a], 60 - 10 - 15);
      EXPECT_LE(read.box.hi[a], 60 + 11 + 16);
    }
  }
  EXPECT_EQ(made.report.voxel_bytes, static_cast<uint64_t>(voxels) * sizeof(float));
  EXPECT_LE(voxels, made.report.blocks_read * 16 * 16 * 16);
}

TEST(Surface, takesTheSmallValuesIfTheScaleIsNegative) {
  VolumeLayout layout;
  layout.dims = {60, 60, 60};
  const auto positive = ball(layout);
  layout.value_scale = -1;
  const auto negative = makeMemorySource<float>(layout, [&](auto x, auto y, auto z) {
    return -reinterpret_cast<const float*>(positive->bytes().data())[(z * 60 + y) * 60 + x];
  });
  const Made expected = make(*positive, {.threshold = 11});
  const Made made = make(*negative, {.threshold = 11});
  EXPECT_EQ(sortedTriangles(made.mesh), sortedTriangles(expected.mesh));
  ASSERT_EQ(made.mesh.vertices.size(), expected.mesh.vertices.size());
  for (size_t i = 0; i < made.mesh.vertices.size(); ++i)
    EXPECT_EQ(made.mesh.vertices[i].normal, expected.mesh.vertices[i].normal);
}

TEST(Surface, endsAtVoxelsThatAreNoNumber) {
  VolumeLayout layout;
  layout.dims = {60, 60, 60};
  for (const double scale : {1.0, -1.0}) {
    layout.value_scale = scale;
    const auto source = makeMemorySource<float>(layout, [&](auto x, auto y, auto z) {
      if (x > 30) return std::numeric_limits<double>::quiet_NaN();
      return scale * (20 - length(toDouble({x, y, z}) - Vec3d{30, 30, 30}));
    });
    const Made made = make(*source, {.threshold = 5});
    EXPECT_TRUE(openSides(made.mesh).empty());
    EXPECT_GT(made.mesh.vertices.size(), 500U);
    for (size_t i = 0; i < made.mesh.vertices.size(); ++i) {
      EXPECT_LE(made.mesh.position(i).x, 31);
      EXPECT_NEAR(length(made.mesh.normal(i)), 1, 1e-5);
    }
  }
}

TEST(Surface, isEmptyIfNoValueReachesTheThreshold) {
  const auto source = makeSparseBlobs({});
  const Made made = make(*source, {.threshold = 1000});
  EXPECT_EQ(made.mesh.vertices.size(), 0U);
  EXPECT_EQ(made.report.blocks_read, 0);
}

TEST(Surface, failsOnceWithTheReadersError) {
  const auto source = makeWhiteNoise({80, 60, 60}, VoxelType::kU8, 4);
  for (const int64_t first : {0, 1, 7}) {
    FailingSource failing(*source, FailingSource::Failure::kError, first, FailingSource::kForever);
    EXPECT_NE(
        errorOf([&] { makeFrom(*source, failing, {.threshold = 60, .block = 16, .threads = 4}); }),
        "");
  }
}

TEST(Surface, tellsTheRangeOfEachBlockThatItReadsWhole) {
  const auto source = makeWhiteNoise({60, 45, 40}, VoxelType::kU16, 4);
  const BlockLayout layout = blockLayout(source->layout().dims, 16, 1);
  const auto* voxels = reinterpret_cast<const uint16_t*>(source->bytes().data());
  Mutex mutex;
  std::map<int64_t, ValueRange> told;
  const CheckBlock note = [&](int64_t block, double lo, double hi) {
    const MutexLock lock(mutex);
    EXPECT_TRUE(told.try_emplace(block, ValueRange{lo, hi}).second);
  };
  const Made made = make(*source, {.threshold = 30'000, .check = note});
  EXPECT_EQ(static_cast<int64_t>(told.size()), made.report.blocks_read);
  EXPECT_GT(made.report.blocks_read, layout.blockCount() / 2);
  for (const auto& [block, range] : told) {
    const Box3 box = layout.ownedVoxels(layout.indexOf(block));
    ValueRange expected{1e9, -1e9};
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (int64_t x = box.lo.x; x < box.hi.x; ++x) {
          const double value = voxels[(z * 45 + y) * 60 + x];
          expected = {std::min(expected.lo, value), std::max(expected.hi, value)};
        }
    EXPECT_EQ(range, expected) << block;
  }
  const CheckBlock refuse = [](int64_t, double, double) { fail("changed"); };
  EXPECT_EQ(errorOf([&] { make(*source, {.threshold = 60, .check = refuse}); }), "changed");
}

TEST(Surface, stopsWhenItIsAskedTo) {
  const auto source = makeWhiteNoise({80, 60, 60}, VoxelType::kU8, 4);
  StopSource stop;
  stop.requestStop();
  EXPECT_THROW(make(*source, {.threshold = 60, .stop = stop.token()}), Interrupted);
}

}  // namespace
}  // namespace sluice::surface_test
