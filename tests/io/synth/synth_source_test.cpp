#include "io/synth/synth_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "io/synth/synth_math.h"
#include "tests/io/synth/synth_voxels.h"

namespace sluice {
namespace {

TEST(SynthMath, sineIsTheLibrarysWithinItsBound) {
  for (int i = -4000; i <= 4000; ++i) {
    const double turns = i * 0.00137;
    EXPECT_NEAR(sineOfTurns(turns), std::sin(2 * std::numbers::pi * turns), 2e-11) << turns;
    EXPECT_NEAR(cosineOfTurns(turns), std::cos(2 * std::numbers::pi * turns), 2e-11) << turns;
  }
}

TEST(SynthSource, voxelsDoNotDependOnTheBoxTheyAreReadWith) {
  for (const SynthKind kind : synthKinds()) {
    const SynthOptions options = small(kind);
    const auto source = openSynth(options);
    const int64_t time = options.time_steps - 1;
    const auto all = readBox<uint8_t>(*source, boxOf(options.dims), time);
    std::mt19937 random(7);
    for (int trial = 0; trial < 60; ++trial) {
      Box3 box;
      for (int a = 0; a < 3; ++a) {
        box.lo[a] = random() % static_cast<unsigned>(options.dims[a]);
        box.hi[a] = box.lo[a] + 1 + random() % static_cast<unsigned>(options.dims[a] - box.lo[a]);
      }
      const auto part = readBox<uint8_t>(*source, box, time);
      size_t i = 0;
      for (int64_t z = box.lo.z; z < box.hi.z; ++z)
        for (int64_t y = box.lo.y; y < box.hi.y; ++y)
          for (int64_t x = box.lo.x; x < box.hi.x; ++x)
            ASSERT_EQ(part[i++],
                      all[static_cast<size_t>((z * options.dims.y + y) * options.dims.x + x)])
                << name(kind) << ' ' << x << ' ' << y << ' ' << z;
    }
  }
}

TEST(SynthSource, typesHoldTheSameFieldInTheirOwnPrecision) {
  for (const SynthKind kind : synthKinds()) {
    if (kind == SynthKind::kParts) continue;  // labels are the same numbers in any type
    SynthOptions options = small(kind);
    const auto bytes = readAll<uint8_t>(options);
    options.type = VoxelType::kU16;
    const auto words = readAll<uint16_t>(options);
    options.type = VoxelType::kF32;
    const auto floats = readAll<float>(options);
    for (size_t i = 0; i < bytes.size(); ++i) {
      ASSERT_NEAR(bytes[i], floats[i] * 255, 0.501) << name(kind);
      ASSERT_NEAR(words[i], floats[i] * 65535, 0.51) << name(kind);
    }
  }
}

// A change of these voxels makes every index and every measurement of older ones wrong: raise
// kRevision in synth_source.cpp with a change here.
TEST(SynthSource, voxelsAreTheSameOnEveryMachine) {
  const std::array<uint64_t, 10> expected = {
      0xa042b63845f4b1cdULL, 0xb643d9f709ef0365ULL, 0x63a486b85a867c91ULL, 0x178f7134fa6dad42ULL,
      0x6d99b02d903da45dULL, 0xadafaa282e2034c1ULL, 0x85eb2c3f7ec6537bULL, 0xcc1f481ba6492840ULL,
      0x044ebb2983c2d305ULL, 0x0c721653c5e3d7a7ULL};
  for (const SynthKind kind : synthKinds()) {
    const SynthOptions options = small(kind);
    uint64_t hash = 14695981039346656037ULL;  // FNV-1a
    for (const uint8_t voxel : readAll<uint8_t>(options, options.time_steps - 1))
      hash = (hash ^ voxel) * 1099511628211ULL;
    EXPECT_EQ(hash, expected[static_cast<size_t>(kind)]) << name(kind);
  }
}

TEST(SynthSource, seedChangesTheVoxelsAndTheIdentity) {
  for (const SynthKind kind : {SynthKind::kPhantom, SynthKind::kNoise, SynthKind::kSparse,
                               SynthKind::kSlab, SynthKind::kFlow, SynthKind::kMixing}) {
    SynthOptions options = small(kind), other = options;
    other.seed = 2;
    EXPECT_NE(readAll<uint8_t>(options), readAll<uint8_t>(other)) << name(kind);
    EXPECT_NE(openSynth(options)->identity(), openSynth(other)->identity());
  }
}

// The published table once more, in degrees, evaluated voxel by voxel.
TEST(SynthSource, phantomIsTheTableOfTenEllipsoids) {
  const double table[10][8] = {{1, .69, .92, .9, 0, 0, 0, 0},
                               {-.8, .6624, .874, .88, 0, 0, 0, 0},
                               {-.2, .41, .16, .21, -.22, 0, -.25, 108},
                               {-.2, .31, .11, .22, .22, 0, -.25, 72},
                               {.2, .21, .25, .5, 0, .35, -.25, 0},
                               {.2, .046, .046, .046, 0, .1, -.25, 0},
                               {.1, .046, .023, .02, -.08, -.65, -.25, 0},
                               {.1, .046, .023, .02, .06, -.65, -.25, 90},
                               {.2, .056, .04, .1, .06, -.105, .625, 90},
                               {-.2, .056, .056, .1, 0, .1, .625, 0}};
  SynthOptions options;
  options.dims = {96, 80, 64};
  options.type = VoxelType::kF32;
  const auto voxels = readAll<float>(options);
  size_t i = 0;
  int differing = 0, air = 0, compared = 0;
  for (int64_t z = 0; z < 64; ++z)
    for (int64_t y = 0; y < 80; ++y)
      for (int64_t x = 0; x < 96; ++x) {
        double density = 0;
        bool near_a_surface = false;
        for (const auto& e : table) {
          const auto inside = [&](double at_x, double at_y, double at_z) {
            const double dx = (at_x + 0.5) / 48 - 1 - e[4], dy = (at_y + 0.5) / 40 - 1 - e[5];
            const double dz = (at_z + 0.5) / 32 - 1 - e[6];
            const double turn = e[7] * std::numbers::pi / 180;
            const double u = dx * std::cos(turn) + dy * std::sin(turn);
            const double v = dy * std::cos(turn) - dx * std::sin(turn);
            return u * u / e[1] / e[1] + v * v / e[2] / e[2] + dz * dz / e[3] / e[3] <= 1;
          };
          const bool here = inside(x, y, z);
          if (here) density += e[0];
          // Edges are soft over a voxel or two.
          for (int corner = 0; corner < 27; ++corner)
            near_a_surface |= here != inside(x + 2 * (corner % 3 - 1), y + 2 * (corner / 3 % 3 - 1),
                                             z + 2 * (corner / 9 - 1));
        }
        const float voxel = voxels[i++];
        if (near_a_surface) continue;
        ++compared;
        if (density < 0.01) {
          ++air;
          if (voxel != 0) ++differing;
        } else if (std::abs(voxel - 0.9 * density) > 0.0301) {
          ++differing;
        }
      }
  EXPECT_EQ(differing, 0);
  EXPECT_GT(air, 100000);
  EXPECT_GT(compared, 300000);
}

TEST(SynthSource, marschnerLobbIsTheirFormula) {
  SynthOptions options;
  options.kind = SynthKind::kMarschnerLobb;
  options.dims = {41, 41, 41};
  options.type = VoxelType::kF32;
  const auto voxels = readAll<float>(options);
  size_t i = 0;
  for (int zi = -20; zi <= 20; ++zi)
    for (int yi = -20; yi <= 20; ++yi)
      for (int xi = -20; xi <= 20; ++xi) {
        const double x = xi / 20.0, y = yi / 20.0, z = zi / 20.0, pi = std::numbers::pi;
        const double ripple = std::cos(2 * pi * 6 * std::cos(pi / 2 * std::sqrt(x * x + y * y)));
        const double expected = (1 - std::sin(pi * z / 2) + 0.25 * (1 + ripple)) / (2 * (1 + 0.25));
        ASSERT_NEAR(voxels[i++], expected, 1e-6) << xi << ' ' << yi << ' ' << zi;
      }
}

TEST(SynthSource, shellsAreRound) {
  SynthOptions options;
  options.kind = SynthKind::kShells;
  options.dims = {65, 65, 65};
  const auto source = openSynth(options);
  const auto at = [&](int64_t x, int64_t y, int64_t z) {
    return readBox<uint8_t>(*source, {{x, y, z}, {x + 1, y + 1, z + 1}})[0];
  };
  // The walls' middles lie at 0.9 i / 5 of the radius, 32.5 voxels.
  for (int shell = 1; shell <= 5; ++shell) {
    const auto r = static_cast<int64_t>(std::lround(32.5 * 0.9 * shell / 5));
    EXPECT_GT(at(32 + r, 32, 32), 0) << shell;
    EXPECT_EQ(at(32 + r, 32, 32), at(32, 32 - r, 32)) << shell;
    EXPECT_EQ(at(32 + r, 32, 32), at(32, 32, 32 + r)) << shell;
    EXPECT_EQ(at(32 + r - 3, 32, 32), 0) << "air inside shell " << shell;
  }
  EXPECT_EQ(at(0, 0, 0), 0);
}

// A voxel's label is the last ellipsoid of the table that holds its centre, in any type.
TEST(SynthSource, partsAreTheEllipsoidsOfThePhantom) {
  SynthOptions options = small(SynthKind::kParts), phantom = small(SynthKind::kPhantom);
  const std::vector<uint8_t> labels = readAll<uint8_t>(options), head = readAll<uint8_t>(phantom);
  options.type = VoxelType::kU16;
  EXPECT_TRUE(std::ranges::equal(readAll<uint16_t>(options), labels));
  std::array<double, 11> sum{}, count{};
  size_t differ = 0;
  for (size_t i = 0; i < labels.size(); ++i) {
    ASSERT_LE(labels[i], 10);
    sum[labels[i]] += head[i];
    count[labels[i]] += 1;
    differ += (labels[i] > 0) != (head[i] > 0);
  }
  EXPECT_LT(static_cast<double>(differ), 0.03 * static_cast<double>(labels.size()))
      << "the rim alone";
  // Parts 6 to 8 are less than three voxels wide here.
  const auto mean = [&](size_t label) { return sum[label] / count[label]; };
  for (const size_t label : {1, 2, 3, 4, 5, 9, 10}) EXPECT_GT(count[label], 20) << label;
  EXPECT_GT(mean(1), 2 * mean(2)) << "bone and brain";
  EXPECT_LT(mean(3), mean(2)) << "a ventricle";
  EXPECT_GT(mean(5), mean(2)) << "a tumour";
  EXPECT_LT(mean(0), 5) << "air";
}

TEST(SynthSource, shareIsKeptAsFarAsItIsPromised) {
  SynthOptions options;
  options.dims = {160, 160, 160};
  for (const double share : {0.02, 0.1, 0.35}) {
    options.object_share = share;
    options.kind = SynthKind::kSlab;
    EXPECT_NEAR(shareOf(readAll<uint8_t>(options)), std::round(share * 160) / 160, 1e-12);
    options.kind = SynthKind::kNoise;
    EXPECT_NEAR(shareOf(readAll<uint8_t>(options)), share, 0.01);
    options.kind = SynthKind::kSparse;
    options.dims = {512, 512, 96};  // 768 bricks: a standard deviation below 0.01
    EXPECT_NEAR(shareOf(readAll<uint8_t>(options)), share, 0.03);
    options.dims = {160, 160, 160};
  }
  options.kind = SynthKind::kCube;
  EXPECT_EQ(shareOf(readAll<uint8_t>(options)), 1);
}

// Bricks come to have a ball by chance, of which a small volume might have none.
TEST(SynthSource, sparseVolumesAreNeverEmpty) {
  SynthOptions options;
  options.kind = SynthKind::kSparse;
  for (options.seed = 1; options.seed <= 20; ++options.seed)
    for (const int64_t side : {8, 20, 33, 40, 64, 100}) {
      options.dims = {side, side, side};
      EXPECT_GT(shareOf(readAll<uint8_t>(options)), 0) << side << ", seed " << options.seed;
    }
}

double correlationOf(const std::vector<uint8_t>& u, const std::vector<uint8_t>& v) {
  double n = 0, su = 0, sv = 0, suu = 0, svv = 0, suv = 0;
  for (size_t i = 0; i < u.size(); ++i) {
    n += 1, su += u[i], sv += v[i];
    suu += u[i] * u[i], svv += v[i] * v[i], suv += u[i] * v[i];
  }
  return (n * suv - su * sv) / std::sqrt((n * suu - su * su) * (n * svv - sv * sv));
}

TEST(SynthSource, flowMovesALittleEachStep) {
  SynthOptions options;
  options.kind = SynthKind::kFlow;
  options.dims = {64, 64, 64};
  options.time_steps = 30;
  const auto step = [&](int64_t time) { return readAll<uint8_t>(options, time); };
  EXPECT_GT(correlationOf(step(10), step(11)), 0.98);
  EXPECT_LT(correlationOf(step(10), step(11)), 1 - 1e-6);
  EXPECT_LT(correlationOf(step(0), step(29)), 0.8);
  EXPECT_GT(shareOf(step(29)), 0.01);
  EXPECT_LT(shareOf(step(29)), 0.25);
}

// Planes of z that are one value throughout: below the layer, the layer, above it.
struct Planes {
  int64_t heavy = 0, mixed = 0, light = 0;
};
Planes planesOf(const std::vector<uint8_t>& voxels, Vec3i dims) {
  Planes planes;
  for (int64_t z = 0; z < dims.z; ++z) {
    const auto first = voxels.begin() + z * dims.x * dims.y, last = first + dims.x * dims.y;
    const auto [least, greatest] = std::minmax_element(first, last);
    ++(*least < *greatest ? planes.mixed : *least == 0 ? planes.light : planes.heavy);
  }
  return planes;
}

TEST(SynthSource, mixingGrowsAcrossALayerAndLeavesTheRestAsItIs) {
  SynthOptions options;
  options.kind = SynthKind::kMixing;
  options.dims = {48, 40, 64};
  options.time_steps = 64;
  const auto step = [&](int64_t time) { return readAll<uint8_t>(options, time); };
  const auto early = step(4), late = step(63);
  const Planes thin = planesOf(early, options.dims), thick = planesOf(late, options.dims);
  EXPECT_LT(thin.mixed, thick.mixed);
  EXPECT_GT(thick.mixed, 20);
  EXPECT_GT(thick.heavy, 5);
  EXPECT_GT(thick.light, 5);
  EXPECT_EQ(early[0], 191);  // 0.75 of 255
  EXPECT_EQ(early.back(), 0);
  // Heavy below: half of the volume, and it stays about as much.
  EXPECT_NEAR(shareOf(early), 0.5, 0.05);
  EXPECT_NEAR(shareOf(late), 0.5, 0.08);
  EXPECT_GT(correlationOf(step(62), late), 0.99);
  EXPECT_LT(correlationOf(step(62), late), 1 - 1e-6);
  EXPECT_LT(correlationOf(early, late), 0.97);
  // Columns across the layer leave the heavy gas more than once: crests that rolled up.
  int64_t overhanging = 0;
  const int64_t plane = options.dims.x * options.dims.y;
  for (int64_t column = 0; column < plane; ++column) {
    int64_t rises = 0;
    for (int64_t z = 1; z < options.dims.z; ++z) {
      const auto at = static_cast<size_t>(z * plane + column);
      rises += late[at] > 0 && late[at - static_cast<size_t>(plane)] == 0;
    }
    overhanging += rises > 0;
  }
  EXPECT_GT(overhanging, plane / 100);
}

TEST(SynthSource, readsAtTheFarEndOfAHugeVolume) {
  for (const SynthKind kind : synthKinds()) {
    SynthOptions options = small(kind);
    options.dims = {100000, 90000, 80000};
    const auto source = openSynth(options);
    const Box3 corner = {options.dims - Vec3i{40, 40, 40}, options.dims};
    EXPECT_EQ(readBox<uint8_t>(*source, corner).size(), 64000U) << name(kind);
  }
  SynthOptions options = small(SynthKind::kCube);
  options.dims = {100000, 90000, 80000};
  EXPECT_THAT(
      readBox<uint8_t>(*openSynth(options), {{99999, 89999, 79998}, {100000, 90000, 80000}}),
      testing::ElementsAre(128, 128));
}

TEST(SynthSource, occupancyHoldsEveryVoxelThatIsNotZero) {
  const SynthOptions options = small(SynthKind::kSlab);
  const auto source = openSynth(options);
  const auto occupancy = source->occupancy(0);
  ASSERT_TRUE(occupancy.has_value());
  ASSERT_EQ(occupancy->boxes.size(), 1U);
  const Box3 box = occupancy->boxes[0];
  EXPECT_EQ(box.size(), (Vec3i{70, 50, 13}));
  const auto voxels = readAll<uint8_t>(options);
  for (int64_t z = 0; z < 66; ++z)
    EXPECT_EQ(voxels[static_cast<size_t>(z * 3500)] != 0, box.contains(Vec3i{0, 0, z})) << z;
}

}  // namespace
}  // namespace sluice
