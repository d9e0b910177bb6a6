// Boxes of the real volumes: right, and tight at usual thresholds whatever they are.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "io/open_volume.h"
#include "tests/classify/boxes/partition.h"

namespace sluice::growing_boxes_data_test {
namespace {

struct RealVolume {
  const char* path;
  // Shares of the range from the least to the greatest value; 0.157 is bonsai's usual 40, 0.314
  // engine's 80.
  std::vector<double> thresholds{0.01, 0.04, 0.08, 0.157, 0.314, 0.6};
  friend void PrintTo(const RealVolume& volume, std::ostream* out) { *out << volume.path; }
};

struct Enclosed {
  int64_t cells = 0, boxes = 0;
  void add(const Box3& box) {
    cells += box.count();
    ++boxes;
  }
};

Enclosed enclosedAt(const VolumePartition& boxes, double threshold) {
  Enclosed visible;
  for (const auto& [cells, box] : boxes)
    if (box.range.hi >= threshold) visible.add(cells);
  return visible;
}

class GrowingBoxesData : public testing::TestWithParam<RealVolume> {};

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

TEST_P(GrowingBoxesData, boxesAreRightAndTight) {
  const std::filesystem::path path = std::filesystem::path(SLUICE_DATA_DIR) / GetParam().path;
  // A pattern's folder stands for it.
  const auto there =
      path.filename().string().find('%') == std::string::npos ? path : path.parent_path();
  if (!std::filesystem::exists(there)) GTEST_SKIP() << there << " is not there";
#ifndef SLUICE_HAS_VDB
  if (path.extension() == ".vdb") GTEST_SKIP() << there << ": built without OpenVDB";
#endif
  const auto source = openVolume(path.string(), {});
  const DeviceVolume volume(*source);
  const VolumePartition grown = grownPartition(volume, 64), leaves = treePartition(volume, 64);
  {
    SCOPED_TRACE("grown boxes");
    expectRight(volume, grown);
  }
  {
    SCOPED_TRACE("leaves of the trees");
    expectRight(volume, leaves);
  }
  EXPECT_LE(leaves.size(), grown.size() * 5 / 4);
  EXPECT_GE(leaves.size(), grown.size() / 2);

  const Vec3i cells = volume.cells().size();
  const Vec3i bricks{ceilDiv(cells.x, 8), ceilDiv(cells.y, 8), ceilDiv(cells.z, 8)};
  const std::vector<float> maxima = brickMaxima(volume, bricks);
  for (const double share : GetParam().thresholds) {
    SCOPED_TRACE(fmt::format("threshold at {} of the range", share));
    const double threshold = volume.range.lo + share * (volume.range.hi - volume.range.lo);
    Enclosed perfect;
    for (size_t i = 0; i < maxima.size(); ++i) {
      if (maxima[i] < threshold) continue;
      const auto at = static_cast<int64_t>(i);
      const Vec3i lo =
          Vec3i{at % bricks.x, at / bricks.x % bricks.y, at / (bricks.x * bricks.y)} * 8;
      perfect.add(intersect({lo, lo + Vec3i{8, 8, 8}}, volume.cells()));
    }
    ASSERT_GT(perfect.boxes, 16) << "shows too little to mean anything";
    for (const VolumePartition* boxes : {&grown, &leaves}) {
      const Enclosed visible = enclosedAt(*boxes, threshold);
      const double ratio = static_cast<double>(visible.cells) / static_cast<double>(perfect.cells);
      EXPECT_LE(ratio, 1.35) << (boxes == &grown ? "grown" : "leaves");
      EXPECT_LT(visible.boxes, perfect.boxes) << (boxes == &grown ? "grown" : "leaves");
    }
  }
}

std::string testName(const testing::TestParamInfo<RealVolume>& info) {
  std::string name = info.param.path;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(
    Data, GrowingBoxesData,
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
}  // namespace sluice::growing_boxes_data_test
