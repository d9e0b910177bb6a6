// Blocks of coarser levels that lose part of a surface: what a report counts, against plain loops
// over all voxels of level 0.
#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include "src/render/blocks/losses/lost_surfaces.h"
#include "tests/render/level_scene.h"

namespace sluice {
namespace {

constexpr int64_t kSide = 72;  // voxels of level 0, a whole number of voxels of each level
constexpr double kInside = 200, kOutside = 20;
using Field = std::function<double(Vec3d)>;

double at(const Field& field, int64_t x, int64_t y, int64_t z) {
  return field({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
}

Field sheet(double thickness) {
  return [=](Vec3d p) {
    const double distance = dot(p, normalized(Vec3d{1, 0.7, 0.4})) - 50.3;
    return std::abs(distance) < thickness / 2 ? kInside : kOutside;
  };
}
double fromMiddle(Vec3d p) {
  return length(p - Vec3d{35.3, 36.1, 34.2});
}
Field shell(double thickness) {
  return [=](Vec3d p) { return std::abs(fromMiddle(p) - 25) < thickness / 2 ? kInside : kOutside; };
}
double thickBall(Vec3d p) {
  return fromMiddle(p) < 25 ? kInside : kOutside;
}
// A scan of a ball: soft edges, and noise that is the same at each call.
double noisyBall(Vec3d p) {
  const double edge = std::clamp(0.5 + (25 - fromMiddle(p)) / 3, 0.0, 1.0);
  const double mixed = std::sin(12.9898 * p.x + 78.233 * p.y + 37.719 * p.z) * 43758.5453;
  return kOutside + (kInside - kOutside) * edge + 40 * (mixed - std::floor(mixed) - 0.5);
}
// A sheet along two axes with a hole that has no sheet.
double sheetWithHole(Vec3d p) {
  const bool is_thick = length(Vec3d{p.x - 30, p.y - 30, 0}) > 9;
  return p.z >= 30 && p.z < (is_thick ? 36 : 31) ? kInside : kOutside;
}

// Voxels of a cube, in plain loops.
struct Voxels {
  int64_t side = 0;
  std::vector<double> of;

  double at(int64_t x, int64_t y, int64_t z) const {
    return of[static_cast<size_t>((z * side + y) * side + x)];
  }
  // Whether the eight voxels of a cell lie on both sides of the value.
  bool passes(Vec3i cell, double value) const {
    bool below = false, above = false;
    for (int corner = 0; corner < 8; ++corner) {
      const double voxel =
          at(cell.x + (corner & 1), cell.y + (corner >> 1 & 1), cell.z + (corner >> 2));
      (voxel < value ? below : above) = true;
    }
    return below && above;
  }
};

Voxels voxelsOf(const Field& field) {
  Voxels voxels{kSide, {}};
  for (int64_t z = 0; z < kSide; ++z)
    for (int64_t y = 0; y < kSide; ++y)
      for (int64_t x = 0; x < kSide; ++x) voxels.of.push_back(at(field, x, y, z));
  return voxels;
}
Voxels meansOf(const Voxels& finest, int64_t side) {
  Voxels means{kSide / side, {}};
  for (int64_t z = 0; z < means.side; ++z)
    for (int64_t y = 0; y < means.side; ++y)
      for (int64_t x = 0; x < means.side; ++x) {
        double sum = 0;
        for (int64_t i = 0; i < side * side * side; ++i)
          sum += finest.at(side * x + i % side, side * y + i / side % side,
                           side * z + i / side / side);
        means.of.push_back(sum / static_cast<double>(side * side * side));
      }
  return means;
}

// The blocks of a level in whose regions level 0 passes the value in a cell while the means pass it
// nowhere within a voxel of the coarse cell that holds the middle of this one.
std::set<int64_t> lostBlocks(const Field& field, double value, const PyramidLayout& layout,
                             int level) {
  const int64_t side = int64_t{1} << level;
  const Voxels finest = voxelsOf(field), means = meansOf(finest, side);
  std::set<int64_t> lost;
  for (int64_t z = 0; z + 1 < kSide; ++z)
    for (int64_t y = 0; y + 1 < kSide; ++y)
      for (int64_t x = 0; x + 1 < kSide; ++x) {
        const Vec3i cell{x, y, z};
        if (!finest.passes(cell, value)) continue;
        Vec3i coarse;
        for (int a = 0; a < 3; ++a) {
          const double middle = static_cast<double>(cell[a]) + 0.5;
          const double place =
              (middle - static_cast<double>(side - 1) / 2) / static_cast<double>(side);
          coarse[a] =
              std::clamp<int64_t>(static_cast<int64_t>(std::floor(place)), 0, means.side - 2);
        }
        bool is_kept = false;
        for (int64_t k = std::max<int64_t>(coarse.z - 1, 0);
             k <= std::min(coarse.z + 1, means.side - 2); ++k)
          for (int64_t j = std::max<int64_t>(coarse.y - 1, 0);
               j <= std::min(coarse.y + 1, means.side - 2); ++j)
            for (int64_t i = std::max<int64_t>(coarse.x - 1, 0);
                 i <= std::min(coarse.x + 1, means.side - 2); ++i)
              is_kept = is_kept || means.passes({i, j, k}, value);
        if (is_kept) continue;
        const BlockLayout& blocks = layout.level(level).blocks;
        lost.insert(blocks.idOf({x / layout.level(level).width.x, y / layout.level(level).width.y,
                                 z / layout.level(level).width.z}));
      }
  return lost;
}

TransferFunction surfaceAt(double value) {
  TransferFunction transfer;
  transfer.colors = {{0, {0.2, 0.5, 1}}, {200, {1, 0.7, 0.1}}};
  transfer.opacities = {{0, 0}};
  transfer.surfaces = {{value, 1, {1, 1, 1}}};
  return transfer;
}

class LostSurfacesTest : public LevelCutTest {
 protected:
  struct Scene {
    std::unique_ptr<MemorySource> source;
    std::unique_ptr<Pyramid> pyramid;
    std::unique_ptr<Session> session;
  };
  static Scene sceneOf(const Field& field, double value, Spreads spreads = Spreads::kKept) {
    Scene scene;
    scene.source = makeMemorySource<float>(
        Vec3i{kSide, kSide, kSide},
        [&](int64_t x, int64_t y, int64_t z) { return static_cast<float>(at(field, x, y, z)); });
    scene.pyramid = std::make_unique<Pyramid>(*scene.source, 4, true, spreads);
    scene.session = sessionOf(*scene.pyramid, surfaceAt(value), true);
    return scene;
  }
  static FrameOptions levelView(int level) {
    FrameOptions options = obliqueView(Projection::kOrtho, {40, 40});
    options.cut = CutOptions{.level = level};
    return options;
  }
  struct Counted {
    int64_t reported = 0;
    std::set<int64_t> found;  // by losesSurface()
  };
  static Counted counted(const Scene& scene, double value, const FrameOptions& options) {
    scene.session->setOptions(options);
    const Frame frame = scene.session->frame();
    Counted result{frame.report.cut->thin_blocks, {}};
    for (const ObjectBlock& object : frame.blocks->blocks) {
      const VolumeBlockPtr block = scene.session->readBlocks({&object.name, 1}).front();
      if (losesSurface(object.name, *block,
                       {scene.pyramid->layout(), *scene.pyramid->step.ranges, object.cells, value}))
        result.found.insert(object.name.block);
    }
    return result;
  }
  static int64_t countWithout(const std::set<int64_t>& blocks, const std::set<int64_t>& others) {
    return std::ranges::count_if(blocks, [&](int64_t block) { return !others.contains(block); });
  }
};

struct Case {
  const char* name;
  Field field;
  double value;
  int64_t most_missed = 0;  // blocks that an estimate from means and spreads may miss
};

TEST_F(LostSurfacesTest, countsTheBlocksInWhichPlainLoopsFindThem) {
  const std::vector<Case> cases{
      {"sheet of 1", sheet(1), 110},         {"sheet of 2", sheet(2), 110},
      {"shell of 1", shell(1), 110},         {"shell of 2", shell(2), 110},
      {"high in a sheet", sheet(2), 180, 4}, {"thin spot", sheetWithHole, 110}};
  for (const Spreads spreads : {Spreads::kKept, Spreads::kNone})
    for (const Case& of : cases) {
      const Scene scene = sceneOf(of.field, of.value, spreads);
      for (const int level : {1, 2, 3}) {
        const auto lost = lostBlocks(of.field, of.value, scene.pyramid->layout(), level);
        const Counted report = counted(scene, of.value, levelView(level));
        const int64_t missed = countWithout(lost, report.found),
                      others = countWithout(report.found, lost);
        SCOPED_TRACE(testing::Message()
                     << of.name << ", level " << level << ": " << lost.size() << " lost, " << missed
                     << " missed, " << others << " others, reported " << report.reported);
        EXPECT_EQ(report.reported, static_cast<int64_t>(report.found.size()));
        // Means alone tell of no holes in a block of level 0.
        EXPECT_TRUE(spreads == Spreads::kNone || missed <= of.most_missed);
        EXPECT_LE(others, spreads == Spreads::kKept ? 1 : 0);
      }
    }
}

TEST_F(LostSurfacesTest, countsNothingInThickBodies) {
  for (const Field& field : {Field(thickBall), Field(noisyBall)}) {
    const Scene scene = sceneOf(field, 110);
    for (const int level : {1, 2}) {
      EXPECT_TRUE(lostBlocks(field, 110, scene.pyramid->layout(), level).empty());
      EXPECT_EQ(counted(scene, 110, levelView(level)).reported, 0) << "level " << level;
    }
  }
}

TEST_F(LostSurfacesTest, refinesThemToKeepWhatIsThin) {
  for (const Field& field : {sheet(1), shell(1)}) {
    const Scene scene = sceneOf(field, 110);
    FrameOptions options = obliqueView(Projection::kOrtho, {40, 40});
    options.cut = CutOptions{.pixel_error = 16};
    EXPECT_GT(draw(*scene.session, options).report.cut->thin_blocks, 0);
    options.cut->keeps_thin = true;
    const FrameReport kept = draw(*scene.session, options).report;
    EXPECT_EQ(kept.cut->thin_blocks, 0);
    EXPECT_TRUE(kept.cut->is_final);
  }
}

// Blocks that are in memory are judged again for other surfaces.
TEST_F(LostSurfacesTest, countsForTheSurfacesThatAreDrawnNow) {
  const Scene scene = sceneOf(shell(2), 110);
  EXPECT_EQ(counted(scene, 110, levelView(1)).reported, 0);
  scene.session->setTransferFunction(surfaceAt(190));
  const Counted high = counted(scene, 190, levelView(1));
  EXPECT_GT(high.found.size(), 4U);
  EXPECT_EQ(high.reported, static_cast<int64_t>(high.found.size()));
}

}  // namespace
}  // namespace sluice
