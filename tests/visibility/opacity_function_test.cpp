// Opacity functions against single rays: thousands of them through random blocks, sampled as
// pictures are, in plain loops.
#include "src/visibility/plenoptic/opacity_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sluice {
namespace {

// Cubes of one cell, each with the value of the part of four cells a side that it is in.
BlockParts partsOf(Vec3i cells, const auto& value) {
  BlockParts parts{{cells, 4}, {}}, cubes{{cells, 1}, {}};
  const Vec3i count = parts.grid.count();
  for (int64_t z = 0; z < count.z; ++z)
    for (int64_t y = 0; y < count.y; ++y)
      for (int64_t x = 0; x < count.x; ++x)
        parts.least.push_back(static_cast<float>(value(x, y, z)));
  for (int64_t z = 0; z < cells.z; ++z)
    for (int64_t y = 0; y < cells.y; ++y)
      for (int64_t x = 0; x < cells.x; ++x)
        cubes.least.push_back(
            parts.least[static_cast<size_t>((z / 4 * count.y + y / 4) * count.x + x / 4)]);
  return cubes;
}

TEST(OpacityFunction, uniformBlockIsItsExtinctionFromEverySide) {
  for (const double extinction : {0.001, 0.1, 2.5}) {
    const OpacityFunction function =
        opacityFunction(partsOf({31, 31, 31}, [&](auto...) { return extinction; }), {});
    EXPECT_TRUE(function.ratios.empty());
    EXPECT_TRUE(function.parts.empty());
    EXPECT_EQ(function.bytes(), 1U);
    EXPECT_NEAR(unpackExtinction(function.floor), extinction, 0.05 * extinction);
    EXPECT_LE(unpackExtinction(function.floor), static_cast<float>(extinction));
  }
}

TEST(OpacityFunction, whatIsEmptyHidesNothing) {
  const OpacityFunction function =
      opacityFunction(partsOf({31, 31, 31}, [](auto...) { return 0; }), {});
  EXPECT_TRUE(function.empty());
}

// A slab across z: all rays near z cross it, rays along x may miss it.
TEST(OpacityFunction, aSlabHidesFromAboveAlone) {
  const DirectionGrid directions{8};
  const OpacityFunction function = opacityFunction(
      partsOf({32, 32, 32}, [](auto, auto, int64_t z) { return z >= 2 && z < 7 ? 1.0 : 0.0; }),
      directions);
  ASSERT_FALSE(function.ratios.empty());
  EXPECT_EQ(function.floor, 0);
  const auto ratio = [&](Vec3d direction) {
    return unpackExtinction(function.ratios[static_cast<size_t>(directions.cellOf(direction))]);
  };
  EXPECT_GT(ratio({0.02, 0.01, 1}), 0.2F);
  EXPECT_GT(ratio({0.02, 0.01, -1}), 0.2F);
  EXPECT_EQ(ratio({1, 0.01, 0.02}), 0);
  EXPECT_EQ(ratio({0.02, 1, 0.02}), 0);
}

struct Ray {
  Vec3d at, step;  // cells; sample k at at + (k + 1/2) step
};

// The sum of a ray's samples, its thickness in samples, and how far it runs along each axis.
struct Passed {
  double sum = 0, slices = 0;
};
Passed passed(const BlockParts& parts, const Ray& ray, double length_vox) {
  double from = -1e9, to = 1e9;
  for (int a = 0; a < 3; ++a) {
    const double size = static_cast<double>(parts.grid.cells[a]);
    const double u = (0 - ray.at[a]) / ray.step[a], v = (size - ray.at[a]) / ray.step[a];
    from = std::max(from, std::min(u, v));
    to = std::min(to, std::max(u, v));
  }
  Passed result;
  result.slices = std::max(0.0, to - from);
  const Vec3i count = parts.grid.cells;
  for (auto k = static_cast<int64_t>(std::ceil(from - 0.5)); k + 0.5 < to; ++k) {
    const Vec3d p = ray.at + ray.step * (static_cast<double>(k) + 0.5);
    Vec3i part{static_cast<int64_t>(p.x), static_cast<int64_t>(p.y), static_cast<int64_t>(p.z)};
    part = min(max(part, {0, 0, 0}), count - Vec3i{1, 1, 1});
    result.sum += length_vox *
                  parts.least[static_cast<size_t>((part.z * count.y + part.y) * count.x + part.x)];
  }
  return result;
}

TEST(OpacityFunction, noRayAccumulatesLess) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1), sign(-1, 1);
  int meaningful = 0;
  for (int block = 0; block < 40; ++block) {
    const DirectionGrid directions{2 + block % 5};
    const double holes = 0.3 * unit(random);
    const Vec3i cells{20 + block % 12, 31, 29};
    const BlockParts parts = partsOf(
        cells, [&](auto...) { return unit(random) < holes * holes ? 0.0 : 0.02 + unit(random); });
    const OpacityFunction function = opacityFunction(parts, directions);
    const PartGrid grid = partsOfCubes(parts.grid);
    ASSERT_EQ(function.parts.size(), static_cast<size_t>(volume(grid.count())));
    for (int i = 0; i < 3000; ++i) {
      Vec3d direction{sign(random), sign(random), sign(random)};
      if (length(direction) < 0.1) continue;
      direction = normalized(direction);
      const double step = 0.3 + 0.7 * unit(random);
      Ray ray{{}, direction * step};
      for (int a = 0; a < 3; ++a)
        ray.at[a] = static_cast<double>(cells[a]) * unit(random) - 40 * ray.step[a] +
                    ray.step[a] * unit(random);
      const Passed found = passed(parts, ray, step);
      const int cell = directions.cellOf(direction);
      const int axis = directions.slopesOf(cell).axis;
      const double least = leastDepthVox(grid, axis) / std::abs(ray.step[axis]);
      const double floor = unpackExtinction(function.floor);
      EXPECT_GE(found.sum, floor * (found.slices - 1) * step - 1e-9);
      if (found.slices < least || function.ratios.empty()) continue;
      const double ratio = unpackExtinction(function.ratios[static_cast<size_t>(cell)]);
      meaningful += ratio > floor ? 1 : 0;
      EXPECT_GE(found.sum,
                (floor * (found.slices - 1) + (ratio - floor) * found.slices) * step - 1e-9)
          << "block " << block << " direction " << direction.x << " " << direction.y << " "
          << direction.z;
    }
  }
  EXPECT_GT(meaningful, 1000);
}

TEST(OpacityFunction, aFamilyAddsUpExtinctions) {
  const auto a = opacityFunction(partsOf({31, 31, 31}, [](auto...) { return 0.1; }), {});
  const auto b = opacityFunction(
      partsOf({31, 31, 31}, [](int64_t x, auto, auto) { return x < 4 ? 0.5 : 0.0; }), {});
  const OpacityFunction both = combined({&a, &b}, {2, 0.5}, {{31, 31, 31}, 1});
  EXPECT_NEAR(unpackExtinction(both.floor), 0.2, 0.02);
  ASSERT_EQ(both.parts.size(), 512U);
  EXPECT_NEAR(unpackExtinction(both.parts[0]), 0.45, 0.05);
  EXPECT_NEAR(unpackExtinction(both.parts[7]), 0.2, 0.02);
  EXPECT_EQ(combined({&b}, {1}, {{31, 31, 31}, 1}), b);
}

TEST(Directions, everyDirectionIsInTheSlopesOfItsCell) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> sign(-1, 1);
  for (const int rows : {1, 2, 4, 9}) {
    const DirectionGrid directions{rows};
    for (int i = 0; i < 20000; ++i) {
      const Vec3d d{sign(random), sign(random), i % 7 == 0 ? 0 : sign(random)};
      if (length(d) < 0.1) continue;
      const int cell = directions.cellOf(d);
      if (d.z != 0) {
        ASSERT_EQ(cell, directions.cellOf(d * -3.0));
      }
      const DirectionSlopes slopes = directions.slopesOf(cell);
      const double w = d[slopes.axis];
      if (rows == 1) continue;  // a quarter of the sky has no main axis
      const double u = d[(slopes.axis + 1) % 3] / w, v = d[(slopes.axis + 2) % 3] / w;
      EXPECT_GE(u, slopes.u_lo - 1e-9);
      EXPECT_LE(u, slopes.u_hi + 1e-9);
      EXPECT_GE(v, slopes.v_lo - 1e-9);
      EXPECT_LE(v, slopes.v_hi + 1e-9);
    }
  }
}

TEST(Directions, allThatLeadToABoxAreFound) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  const DirectionGrid directions{5};
  size_t few = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3d eye{300 * unit(random) - 150, 300 * unit(random) - 150, 300 * unit(random) - 150};
    const Vec3d lo{0, 0, 0}, hi{31, 20 + 11 * unit(random), 31};
    const std::vector<int> cells = directions.cellsToward(eye, lo, hi);
    few += cells.size() < 20 ? 1U : 0U;
    for (int k = 0; k < 100; ++k) {
      const Vec3d at{hi.x * unit(random), hi.y * unit(random), hi.z * unit(random)};
      EXPECT_TRUE(std::binary_search(cells.begin(), cells.end(), directions.cellOf(at - eye)));
    }
  }
  EXPECT_GT(few, 150U);
}

}  // namespace
}  // namespace sluice
