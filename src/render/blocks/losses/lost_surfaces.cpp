#include "src/render/blocks/losses/lost_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "src/classify/blocks/classifier.h"

namespace sluice {
namespace {

// Levels above have more finest blocks in a block's region, each narrower than two coarse voxels,
// so that ShownLevels::hasThinParts() finds nearly all of them thin.
constexpr int kMostLevel = 5;

// A voxel has a mean on this side of the value, or may hold values there.
enum Side : uint8_t { kBelow = 1, kAbove = 2, kMayBeBelow = 4, kMayBeAbove = 8 };
constexpr uint8_t kPassed = kBelow | kAbove, kMayPass = kMayBeBelow | kMayBeAbove;
constexpr bool hasAll(uint8_t sides, uint8_t of) {
  return (sides & of) == of;
}

// The sides that occur in each place of a box, x fastest.
struct Sides {
  Box3 places;
  std::vector<uint8_t> of;

  uint8_t at(Vec3i p) const {
    const Vec3i local = p - places.lo, size = places.size();
    return of[static_cast<size_t>((local.z * size.y + local.y) * size.x + local.x)];
  }
};

Sides sidesOfVoxels(const VolumeBlock& block, double value) {
  Sides sides{block.voxels, std::vector<uint8_t>(static_cast<size_t>(block.voxels.count()))};
  visitDeviceType(block.type, [&](auto zero) {
    using T = decltype(zero);
    const auto* means = reinterpret_cast<const T*>(block.bytes.get());
    const auto* spreads = reinterpret_cast<const T*>(block.bytes.get() + block.planeBytes());
    // A spread is two deviations, and float is exact for all device values of fewer bits.
    const auto reach = static_cast<float>(kLostDeviations / 2), at = static_cast<float>(value);
    for (size_t i = 0; i < sides.of.size(); ++i) {
      const auto mean = static_cast<float>(means[i]);
      const float spread = block.numbers == 2 ? reach * static_cast<float>(spreads[i]) : 0;
      // A NaN is on no side.
      const int found = (mean < at ? kBelow : 0) | (mean >= at ? kAbove : 0) |
                        (mean - spread < at ? kMayBeBelow : 0) |
                        (mean + spread >= at ? kMayBeAbove : 0);
      sides.of[i] = static_cast<uint8_t>(found);
    }
  });
  return sides;
}

// The cells between the voxels, each with the sides of its eight corners.
Sides sidesOfCells(const Sides& voxels) {
  // A cell has the sides of all its corners: it is passed if it has both.
  Sides cells{{voxels.places.lo, voxels.places.hi - Vec3i{1, 1, 1}}, {}};
  cells.of.resize(static_cast<size_t>(cells.places.count()));
  const Vec3i size = voxels.places.size();
  uint8_t* to = cells.of.data();
  for (int64_t z = 0; z + 1 < size.z; ++z)
    for (int64_t y = 0; y + 1 < size.y; ++y) {
      const uint8_t* row = voxels.of.data() + (z * size.y + y) * size.x;
      const uint8_t *above = row + size.x, *next = row + size.y * size.x, *both = next + size.x;
      for (int64_t x = 0; x + 1 < size.x; ++x)
        *to++ = static_cast<uint8_t>(row[x] | row[x + 1] | above[x] | above[x + 1] | next[x] |
                                     next[x + 1] | both[x] | both[x + 1]);
    }
  return cells;
}

bool anyPassed(const Sides& cells, const Box3& among) {
  const Box3 box = intersect(cells.places, among);
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y)
      for (int64_t x = box.lo.x; x < box.hi.x; ++x)
        if (hasAll(cells.at({x, y, z}), kPassed)) return true;
  return false;
}

Box3 withCellsAround(const Box3& cells) {
  const Vec3i one{1, 1, 1};
  return {cells.lo - one, cells.hi + one};
}

// The level's cells whose middles lie in these finest cells: each in those of one block alone.
Box3 cellsWithMiddleIn(const LevelLayout& level, const Box3& finest) {
  Box3 cells;
  const Vec3d half{0.5, 0.5, 0.5};
  const Vec3d lo = level.placement.levelFromFinest(toDouble(finest.lo)) - half;
  const Vec3d hi = level.placement.levelFromFinest(toDouble(finest.hi)) - half;
  for (int a = 0; a < 3; ++a) {
    cells.lo[a] = static_cast<int64_t>(std::ceil(lo[a]));
    cells.hi[a] = static_cast<int64_t>(std::ceil(hi[a]));
  }
  return cells;
}

bool losesBySpreads(const Sides& cells, const Box3& among) {
  const Box3 box = intersect(cells.places, among);
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y)
      for (int64_t x = box.lo.x; x < box.hi.x; ++x) {
        const uint8_t sides = cells.at({x, y, z});
        const Vec3i cell{x, y, z};
        // The spreads say that both sides may lie here, and the means show only one. A surface that
        // a cell beside this one shows has only moved.
        if (hasAll(sides, kMayPass) && !hasAll(sides, kPassed) &&
            !anyPassed(cells, withCellsAround({cell, cell + Vec3i{1, 1, 1}})))
          return true;
      }
  return false;
}

// The cells of a held block of the finest level between which the value is passed, as far as its
// ranges tell; empty: it is not.
Box3 passedBox(const SliceRanges& finest, size_t held, const Box3& owned, double value) {
  return visitDeviceType(finest.map.type, [&](auto zero) {
    using T = decltype(zero);
    // A surface lies between a value below its own and one that is equal or above.
    const auto passes = [&](T lo, T hi) {
      return static_cast<double>(lo) < value && static_cast<double>(hi) >= value;
    };
    const PlaneRange<T> total = finest.totalsAs<T>()[held];
    return passes(total.lo, total.hi) ? cellsBetween<T>(finest, held, owned, passes) : Box3();
  });
}

bool losesByRanges(const BlockName& name, const Sides& cells, const SurfaceQuestion& asked) {
  if (name.level > kMostLevel) return false;
  const LevelLayout& level = asked.pyramid.of(name);
  const BlockLayout& layout = asked.finest.layout;
  // Blocks that are not held are uniform: no surface lies in them.
  const std::vector<int64_t>& all = asked.finest.blocks;
  const Box3 blocks = asked.pyramid.finestBlocksOf(name);
  for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
    for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y) {
      auto at = std::ranges::lower_bound(all, layout.idOf({blocks.lo.x, y, z}));
      for (; at != all.end() && *at < layout.idOf({blocks.hi.x, y, z}); ++at) {
        const Box3 owned = layout.ownedCells(layout.indexOf(*at));
        const Box3 box = intersect(
            passedBox(asked.finest, static_cast<size_t>(at - all.begin()), owned, asked.value),
            asked.cells);
        if (box.empty()) continue;
        const Box3 voxels = level.voxelsUnder(box);
        Box3 touched{voxels.lo, voxels.hi - Vec3i{1, 1, 1}};
        // Beyond its outermost voxels a level shows their values.
        for (int a = 0; a < 3; ++a) {
          touched.lo[a] = std::min(touched.lo[a], cells.places.hi[a] - 1);
          touched.hi[a] = std::max(touched.hi[a], cells.places.lo[a] + 1);
        }
        // The ranges tell that the finest level passes the value somewhere in the box, not where:
        // it is lost only if no coarse cell of the box passes it.
        if (!anyPassed(cells, withCellsAround(touched))) return true;
      }
    }
  return false;
}

}  // namespace

bool losesSurface(const BlockName& name, const VolumeBlock& block, const SurfaceQuestion& asked) {
  const Sides voxels = sidesOfVoxels(block, asked.value);
  const Sides cells = sidesOfCells(voxels);
  // A block one voxel thick has no cells.
  if (cells.of.empty()) return false;
  return (block.numbers == 2 &&
          losesBySpreads(cells, cellsWithMiddleIn(asked.pyramid.of(name), asked.cells))) ||
         losesByRanges(name, cells, asked);
}

}  // namespace sluice
