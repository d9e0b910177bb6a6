// Partitions against plain loops over voxels, on random volumes and on the real ones.
#include "src/classify/growing_boxes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "io/open_volume.h"
#include "src/volume/block_layout.h"
#include "tests/classify/device_volume.h"
#include "tests/support/random_volume.h"

namespace sluice {
namespace {

constexpr int64_t kSide = 4;

struct VolumeBox {
  Box3 cells;  // in the volume
  GrownBox box;
};

std::vector<VolumeBox> partition(const DeviceVolume& volume, int64_t block_vox) {
  const BlockLayout layout = blockLayout(volume.dims, block_vox, 0);
  const GrowingParameters parameters = growingParameters(volume.map.type, volume.range);
  std::vector<VolumeBox> boxes;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    const Box3 owned = layout.ownedCells(layout.indexOf(block));
    for (const GrownBox& box : growBoxes(brickGrid(volume.span(), owned, kSide), parameters))
      boxes.push_back({translate(box.local(), owned.lo), box});
  }
  return boxes;
}

// Every cell in exactly one box; each interval that of the voxels that its cells touch.
void expectRight(const DeviceVolume& volume, const std::vector<VolumeBox>& boxes) {
  const Vec3i size = volume.cells().size();
  std::vector<uint8_t> taken(static_cast<size_t>(sluice::volume(size)));
  int64_t cells = 0;
  for (const auto& [box, grown] : boxes) {
    ASSERT_FALSE(box.empty());
    ASSERT_TRUE(volume.cells().contains(box));
    float lo = std::numeric_limits<float>::max(), hi = std::numeric_limits<float>::lowest();
    for (int64_t z = box.lo.z; z <= box.hi.z; ++z)
      for (int64_t y = box.lo.y; y <= box.hi.y; ++y) {
        const float* row =
            &volume.values[static_cast<size_t>((z * volume.dims.y + y) * volume.dims.x)];
        for (int64_t x = box.lo.x; x <= box.hi.x; ++x) {
          lo = std::min(lo, row[x]);
          hi = std::max(hi, row[x]);
        }
        if (z == box.hi.z || y == box.hi.y) continue;
        uint8_t* cell = &taken[static_cast<size_t>((z * size.y + y) * size.x)];
        for (int64_t x = box.lo.x; x < box.hi.x; ++x) ASSERT_EQ(cell[x]++, 0);
      }
    ASSERT_EQ(grown.range.lo, lo);
    ASSERT_EQ(grown.range.hi, hi);
    cells += box.count();
  }
  EXPECT_EQ(cells, volume.cells().count());
}

TEST(GrowingBoxes, partitionRandomVolumesOfEveryType) {
  for (const VoxelType type : {VoxelType::kU8, VoxelType::kI16, VoxelType::kU16, VoxelType::kF32})
    for (const uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(fmt::format("{} seed {}", name(type), seed));
      const auto blobs = makeSparseBlobs({.type = type, .seed = seed});
      const DeviceVolume volume(*blobs);
      for (const int64_t block_vox : {16, 32}) expectRight(volume, partition(volume, block_vox));
      const auto noise = makeWhiteNoise({33, 29, 18}, type, seed);
      const DeviceVolume rough(*noise);
      expectRight(rough, partition(rough, 32));
    }
}

TEST(GrowingBoxes, oneValueIsOneUniformBox) {
  const auto source = makeMemorySource<uint8_t>(Vec3i{32, 32, 32}, [](auto...) { return 7; });
  const DeviceVolume volume(*source);
  const auto boxes = partition(volume, 32);
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_EQ(boxes[0].box.type, BoxType::kUniform);
  EXPECT_EQ(boxes[0].box.range, (CellRange{7, 7, 0, 0}));
}

TEST(GrowingBoxes, aSurfaceIsCutFromWhatItDivides) {
  const auto source = makeMemorySource<uint8_t>(
      Vec3i{65, 65, 65}, [](int64_t x, auto...) { return x < 33 ? 10 : 200; });
  const DeviceVolume volume(*source);
  int64_t uniform_cells = 0;
  for (const auto& [cells, box] : partition(volume, 64)) {
    const bool holds_surface = cells.lo.x <= 32 && cells.hi.x > 32;
    if (holds_surface) {
      EXPECT_EQ(box.type, BoxType::kGradient);
    }
    if (holds_surface) {
      EXPECT_LE(cells.size().x, 4 * kSide) << "three bricks in vain for one";
    }
    if (box.type == BoxType::kUniform) uniform_cells += cells.count();
  }
  EXPECT_GE(uniform_cells, volume.cells().count() * 8 / 10);
}

TEST(GrowingBoxes, everyBoxKeepsWithinItsLimits) {
  const auto source = makeSparseBlobs({.dims = {64, 64, 64}, .blobs = 12, .radius_vox = 9});
  const DeviceVolume volume(*source);
  const BrickGrid grid = brickGrid(volume.span(), boxOf({63, 63, 63}), kSide);
  const GrowingParameters parameters;
  for (const GrownBox& box : growBoxes(grid, parameters)) {
    const double cost = costOf(grid, grid.bricksOf(box.local()), box.range, parameters);
    EXPECT_TRUE(isWithinLimits(cost, box.local().count(), parameters)) << cost;
  }
}

TEST(GrowingBoxes, parametersFollowTheRangeOfWiderTypes) {
  EXPECT_EQ(growingParameters(DeviceType::kU8, {0, 100}).uniform_range, 32);
  EXPECT_EQ(growingParameters(DeviceType::kU16, {1000, 1000 + 25600}).uniform_range, 3200);
  EXPECT_FLOAT_EQ(growingParameters(DeviceType::kF32, {-1, 1}).gradient_floor, 1.F / 16);
}

TEST(GrowingBoxes, typesAreThePapers) {
  const GrowingParameters p;
  EXPECT_EQ(typeOf({0, 32, 0, 0}, 512, p), BoxType::kUniform);
  EXPECT_EQ(typeOf({0, 33, 0, 0}, 512, p), BoxType::kOther) << "too wide in values";
  EXPECT_EQ(typeOf({0, 32, 0, 0}, 511, p), BoxType::kOther) << "too small";
  EXPECT_EQ(typeOf({0, 32, 0, 8.5F}, 512, p), BoxType::kGradient);
}

struct RealVolume {
  const char* path;
  // Of the way from the least to the greatest value; 0.157 is bonsai's usual 40, 0.314 engine's 80.
  std::vector<double> thresholds{0.08, 0.157, 0.314, 0.6};
  friend void PrintTo(const RealVolume& volume, std::ostream* out) { *out << volume.path; }
};

class RealVolumes : public testing::TestWithParam<RealVolume> {};

// The greatest value in each aligned 8^3-cell brick of the volume: visible at a threshold up to it.
std::vector<float> brickMaxima(const DeviceVolume& volume, Vec3i bricks) {
  std::vector<float> maxima(static_cast<size_t>(sluice::volume(bricks)),
                            std::numeric_limits<float>::lowest());
  // A voxel plane between two bricks belongs to both.
  const auto span = [](int64_t at, int64_t count) {
    return std::pair{at > 0 && at % 8 == 0 ? at / 8 - 1 : at / 8, std::min(at / 8, count - 1)};
  };
  for (int64_t z = 0; z < volume.dims.z; ++z)
    for (int64_t y = 0; y < volume.dims.y; ++y)
      for (int64_t x = 0; x < volume.dims.x; ++x) {
        const float value = volume.at({x, y, z});
        const auto [x0, x1] = span(x, bricks.x);
        const auto [y0, y1] = span(y, bricks.y);
        const auto [z0, z1] = span(z, bricks.z);
        for (int64_t k = z0; k <= z1; ++k)
          for (int64_t j = y0; j <= y1; ++j)
            for (int64_t i = x0; i <= x1; ++i) {
              float& most = maxima[static_cast<size_t>((k * bricks.y + j) * bricks.x + i)];
              most = std::max(most, value);
            }
      }
  return maxima;
}

TEST_P(RealVolumes, boxesAreRightAndTight) {
  const std::filesystem::path path = std::filesystem::path(SLUICE_DATA_DIR) / GetParam().path;
  // A pattern's folder stands for it.
  const auto there =
      path.filename().string().find('%') == std::string::npos ? path : path.parent_path();
  if (!std::filesystem::exists(there)) GTEST_SKIP() << there << " is not there";
  const auto source = openVolume(path.string(), {});
  const DeviceVolume volume(*source);
  const auto boxes = partition(volume, 64);
  expectRight(volume, boxes);

  const Vec3i cells = volume.cells().size();
  const Vec3i bricks{ceilDiv(cells.x, 8), ceilDiv(cells.y, 8), ceilDiv(cells.z, 8)};
  const std::vector<float> maxima = brickMaxima(volume, bricks);
  for (const double share : GetParam().thresholds) {
    const double threshold = volume.range.lo + share * (volume.range.hi - volume.range.lo);
    int64_t perfect = 0, perfect_count = 0, enclosed = 0, visible = 0;
    for (size_t i = 0; i < maxima.size(); ++i) {
      if (maxima[i] < threshold) continue;
      const auto at = static_cast<int64_t>(i);
      const Vec3i lo =
          Vec3i{at % bricks.x, at / bricks.x % bricks.y, at / (bricks.x * bricks.y)} * 8;
      perfect += intersect({lo, lo + Vec3i{8, 8, 8}}, volume.cells()).count();
      ++perfect_count;
    }
    for (const auto& [box, grown] : boxes)
      if (grown.range.hi >= threshold) {
        enclosed += box.count();
        ++visible;
      }
    ASSERT_GT(perfect_count, 16) << "threshold " << share << " shows too little to mean anything";
    EXPECT_LE(static_cast<double>(enclosed), 1.35 * static_cast<double>(perfect))
        << "threshold " << share << ": "
        << static_cast<double>(enclosed) / static_cast<double>(perfect);
    EXPECT_LT(visible, perfect_count) << "threshold " << share;
  }
}

std::string testName(const testing::TestParamInfo<RealVolume>& info) {
  std::string name = info.param.path;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(
    Data, RealVolumes,
    testing::Values(RealVolume{"bonsai.nii.gz"}, RealVolume{"engine.nii.gz"},
                    RealVolume{"engine_256x256x128_uint8.raw"}, RealVolume{"visible-female-head"},
                    RealVolume{"cthead/%03d.tif"}, RealVolume{"head-mr.nii.gz"},
                    RealVolume{"motor-map.nii.gz"}, RealVolume{"tooth/tooth.nhdr"},
                    RealVolume{"headsq-quarter/quarter.nhdr"}, RealVolume{"HeadMRVolume.mhd"},
                    RealVolume{"nucleon.nrrd"}, RealVolume{"walnut_128x96x114_uint16.raw"},
                    RealVolume{"smoke.vdb"}, RealVolume{"cube.vdb"}, RealVolume{"sphere.vdb"},
                    RealVolume{"viscous-fingers/step_001.nrrd"}),
    testName);

}  // namespace
}  // namespace sluice
