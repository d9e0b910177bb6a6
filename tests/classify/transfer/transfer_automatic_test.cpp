// automaticTransfer on histograms whose background and object are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "src/base/error.h"
#include "src/classify/transfer/automatic_look.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/histogram_analysis.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

using testing::HasSubstr;

Histogram histogramOf(const std::vector<double>& values, size_t bins) {
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  Histogram histogram{{*lo, *hi}, std::vector<uint64_t>(bins, 0)};
  for (const double value : values) ++histogram.counts[binOf(histogram.range, bins, value)];
  return histogram;
}

// Each bin as the interval that it is.
ValueCounts countsOf(const Histogram& histogram) {
  ValueCounts counts;
  for (size_t i = 0; i < histogram.counts.size(); ++i)
    if (histogram.counts[i] > 0)
      counts.entries.push_back(
          {binEdge(histogram, i), binEdge(histogram, i + 1), histogram.counts[i]});
  return counts;
}

TransferFunction automaticTransfer(const Histogram& histogram,
                                   const AutomaticOptions& options = {}) {
  return automaticLook(countsOf(histogram), options).transfer;
}

// Draws of normal distributions, rounded like a scanner's.
class Scene {
 public:
  Scene& add(int count, double mean, double deviation) {
    std::normal_distribution<double> normal(mean, deviation);
    for (int i = 0; i < count; ++i) values_.push_back(normal(random_));
    return *this;
  }
  Scene& addFog(int count, double mean) {
    std::exponential_distribution<double> decaying(1 / mean);
    for (int i = 0; i < count; ++i) values_.push_back(decaying(random_));
    return *this;
  }
  Scene& rounded(double lo, double hi) {
    for (double& value : values_) value = std::clamp(std::round(value), lo, hi);
    return *this;
  }
  Histogram histogram(size_t bins) const { return histogramOf(values_, bins); }
  Histogram byValue() const {
    const auto [lo, hi] = std::minmax_element(values_.begin(), values_.end());
    return histogram(static_cast<size_t>(*hi - *lo) + 1);
  }

 private:
  std::mt19937 random_{3};
  std::vector<double> values_;
};

// -ln of the transmittance of `length` voxels at `value`.
double opticalDepth(const TransferFunction& transfer, double value, double length) {
  return -length * std::log1p(-opacityAt(transfer, value));
}

TEST(AutomaticTransfer, putsTheThresholdBetweenAirAndObject) {
  const auto u8 = Scene().add(70000, 10, 4).add(20000, 90, 8).add(5000, 200, 10).rounded(0, 255);
  const auto found = analyse(u8.byValue());
  EXPECT_EQ(found.kind, HistogramKind::kAbove);
  EXPECT_TRUE(found.valley);
  EXPECT_NEAR(found.background, 10, 5);
  EXPECT_GT(found.threshold, 25);
  EXPECT_LT(found.threshold, 70);
  const auto transfer = automaticTransfer(u8.byValue());
  EXPECT_EQ(opacityAt(transfer, 20), 0);
  EXPECT_GT(opacityAt(transfer, 90), 0);
  EXPECT_GT(opacityAt(transfer, 200), opacityAt(transfer, 90));
  EXPECT_THAT(transfer.name, HasSubstr("automatic above"));
}

TEST(AutomaticTransfer, choosesAlikeInEightBitsSixteenAndFloat) {
  const auto scene = [] { return Scene().add(70000, 10, 4).add(20000, 90, 8); };
  const double u8 = analyse(scene().rounded(0, 255).byValue()).threshold;
  const double f32 = analyse(scene().histogram(4096)).threshold;
  EXPECT_NEAR(u8, f32, 6);
  const auto u16 = Scene().add(70000, 1000, 400).add(20000, 9000, 800).rounded(0, 65535);
  EXPECT_NEAR(analyse(u16.byValue()).threshold, 100 * f32, 600);
}

TEST(AutomaticTransfer, fewBrightOutliersDoNotFlattenTheRest) {
  const auto scene =
      Scene().add(70000, 1000, 100).add(30000, 2000, 100).add(10, 65000, 1).rounded(0, 65535);
  const auto transfer = automaticTransfer(scene.byValue());
  EXPECT_LT(transfer.colors.back().value, 2600);
  EXPECT_GT(transfer.colors.front().value, 1200);
}

TEST(AutomaticTransfer, airAfterPaddingIsBackgroundToo) {
  // Hounsfield units: padding, air, soft tissue, bone.
  const auto ct = Scene()
                      .add(20000, -2000, 0)
                      .add(40000, -1000, 15)
                      .add(30000, 40, 30)
                      .add(4000, 1200, 200)
                      .rounded(-2000, 3000);
  const auto found = analyse(ct.byValue());
  EXPECT_EQ(found.kind, HistogramKind::kAbove);
  EXPECT_GT(found.threshold, -900);
  EXPECT_LT(found.threshold, -50);
}

TEST(AutomaticTransfer, tissueAroundZeroIsNoBackground) {
  const auto ct = Scene().add(30000, -1000, 15).add(60000, 0, 20).add(6000, 1000, 150);
  EXPECT_EQ(analyse(ct.histogram(4096)).kind, HistogramKind::kAbove);
}

TEST(AutomaticTransfer, sparseFogIsVisibleFromItsThinnestOn) {
  const auto fog = Scene().add(900000, 0, 0).addFog(100000, 0.3).histogram(4096);
  const auto found = analyse(fog);
  EXPECT_FALSE(found.valley);
  EXPECT_GT(found.threshold, 0);
  EXPECT_GT(shareAbove(fog, found.threshold), 0.09);
  const auto transfer = automaticTransfer(fog);
  EXPECT_EQ(opacityAt(transfer, 0), 0);
  EXPECT_GT(opacityAt(transfer, 0.1), 0);
}

TEST(AutomaticTransfer, bothTailsOfASignedMapAreVisible) {
  const auto map = Scene().add(60000, 0, 0).add(30000, 0, 1).add(500, 6, 1).add(500, -5, 1);
  const auto histogram = map.histogram(4096);
  EXPECT_EQ(analyse(histogram).kind, HistogramKind::kDiverging);
  const auto transfer = automaticTransfer(histogram);
  EXPECT_EQ(opacityAt(transfer, 0), 0);
  EXPECT_EQ(opacityAt(transfer, 0.5), 0);
  for (const double value : {3.0, 5.0, 8.0}) {
    EXPECT_GT(opacityAt(transfer, value), 0);
    EXPECT_DOUBLE_EQ(opacityAt(transfer, -value), opacityAt(transfer, value));
  }
  EXPECT_GT(colorAt(transfer, 5).x, colorAt(transfer, 5).z);
  EXPECT_LT(colorAt(transfer, -5).x, colorAt(transfer, -5).z);
  EXPECT_DOUBLE_EQ(transfer.colors.front().value, -transfer.colors.back().value);
}

TEST(AutomaticTransfer, objectInABrightFieldIsVisible) {
  const auto field = Scene().add(80000, 250, 2).add(15000, 120, 10).rounded(0, 255);
  const auto found = analyse(field.byValue());
  EXPECT_EQ(found.kind, HistogramKind::kBelow);
  const auto transfer = automaticTransfer(field.byValue());
  EXPECT_EQ(opacityAt(transfer, 250), 0);
  EXPECT_GT(opacityAt(transfer, 120), 0);
  EXPECT_GE(opacityAt(transfer, 90), opacityAt(transfer, 120));
  EXPECT_THAT(transfer.name, HasSubstr("automatic below"));
}

TEST(AutomaticTransfer, croppedObjectOutweighsItsBackground) {
  const auto scene = Scene().add(20000, 5, 2).add(80000, 150, 12).rounded(0, 255);
  const auto found = analyse(scene.byValue());
  EXPECT_GT(found.threshold, 12);
  EXPECT_LT(found.threshold, 120);
}

TEST(AutomaticTransfer, maskOfTwoValuesShowsTheUpper) {
  const ValueCounts mask{{{0, 0, 900}, {1, 1, 100}}};
  const auto transfer = automaticLook(mask).transfer;
  EXPECT_EQ(opacityAt(transfer, 0), 0);
  EXPECT_GT(opacityAt(transfer, 1), 0);
}

TEST(AutomaticTransfer, signedDistanceShowsAShellAroundZero) {
  const Histogram band{{-0.15, 0.15}, std::vector<uint64_t>(300, 10)};
  const auto transfer = automaticTransfer(band, {.signed_distance = true, .finest_spacing = 0.05});
  // Matter behind the surface does not show through it.
  EXPECT_EQ(opacityAt(transfer, 0), 1);
  EXPECT_GT(opacityAt(transfer, 0.02), 0.5);
  for (const double value : {-0.15, -0.08, 0.08, 0.15}) EXPECT_EQ(opacityAt(transfer, value), 0);
  // Without a spacing, and if the band is thinner than the shell would be.
  for (const double spacing : {0.0, 10.0}) {
    const auto other =
        automaticTransfer(band, {.signed_distance = true, .finest_spacing = spacing});
    EXPECT_GT(opacityAt(other, 0), 0.5);
    EXPECT_EQ(opacityAt(other, 0.15), 0);
    EXPECT_EQ(opacityAt(other, -0.15), 0);
  }
}

TEST(AutomaticTransfer, signedDistanceWithoutASurfaceFallsBack) {
  const auto transfer = automaticTransfer({{1, 9}, {5, 5, 5}}, {.signed_distance = true});
  EXPECT_THAT(transfer.name, testing::Not(HasSubstr("shell")));
}

TEST(AutomaticTransfer, constantVolumeIsTranslucent) {
  for (const Histogram& histogram :
       {Histogram{{7, 7}, {1000}}, Histogram{{7, 7}, std::vector<uint64_t>(256, 0)},
        Histogram{{0, 10}, {0, 0, 500, 0}}, Histogram{{7, 7}, {}}}) {
    const auto transfer = automaticTransfer(histogram, {.thickness_vox = 100});
    const double depth = opticalDepth(transfer, histogram.range.lo, 100);
    EXPECT_GT(depth, 0.3);
    EXPECT_LT(depth, 2);
  }
}

TEST(AutomaticTransfer, thickVolumesAreAsDenseToLookThroughAsThinOnes) {
  const auto scene = Scene().add(70000, 10, 4).add(30000, 90, 8).rounded(0, 255).byValue();
  const double thin = opticalDepth(automaticTransfer(scene, {.thickness_vox = 100}), 90, 100);
  const double thick = opticalDepth(automaticTransfer(scene, {.thickness_vox = 1000}), 90, 1000);
  EXPECT_NEAR(thin, thick, 0.1 * thick);
  // Through an object a third as thick: neither a ghost nor a wall.
  EXPECT_GT(thick / 3, 0.3);
  EXPECT_LT(thick / 3, 6);
}

TEST(AutomaticTransfer, takesTheMapThatIsAskedFor) {
  const auto scene = Scene().add(70000, 10, 4).add(30000, 90, 8).rounded(0, 255).byValue();
  const auto transfer = automaticTransfer(scene, {.map = "viridis"});
  EXPECT_EQ(transfer.colors.front().rgb, colorMap("viridis")->front().rgb);
  EXPECT_THROW(automaticTransfer(scene, {.map = "jet"}), Error);
}

TEST(AutomaticTransfer, isValidWhateverTheCounts) {
  std::mt19937_64 random(5);
  const double most = std::numeric_limits<double>::max();
  for (const ValueRange range : {ValueRange{0, 255}, ValueRange{-1, 1}, ValueRange{-1e-300, 1e-300},
                                 ValueRange{-most, most}, ValueRange{-3, 1e9}, ValueRange{4, 4}}) {
    for (int round = 0; round < 60; ++round) {
      Histogram histogram{range, std::vector<uint64_t>(1 + random() % 600, 0)};
      const int filled = static_cast<int>(random() % 20);
      for (int i = 0; i < filled; ++i) {
        histogram.counts[random() % histogram.counts.size()] = random() >> (random() % 60 + 4);
      }
      for (const bool distance : {false, true}) {
        const auto transfer = automaticTransfer(
            histogram, {.thickness_vox = round * 10.0, .signed_distance = distance});
        EXPECT_NO_THROW(validate(transfer, "automatic"));
      }
    }
  }
}

template <class Voxel>
Histogram histogramOfFile(const std::string& name, size_t bins) {
  const std::string bytes = readFile(std::filesystem::path(SLUICE_DATA_DIR) / name);
  std::vector<Voxel> voxels(bytes.size() / sizeof(Voxel));
  std::memcpy(voxels.data(), bytes.data(), voxels.size() * sizeof(Voxel));
  return histogramOf({voxels.begin(), voxels.end()}, bins);
}

#define SKIP_WITHOUT(name)                                                         \
  if (!std::filesystem::exists(std::filesystem::path(SLUICE_DATA_DIR) / (name))) { \
    GTEST_SKIP() << (name) << " is missing from " << SLUICE_DATA_DIR;              \
  }

TEST(AutomaticTransfer, separatesTheEngineFromItsHaze) {
  SKIP_WITHOUT("engine_256x256x128_uint8.raw");
  const auto found = analyse(histogramOfFile<uint8_t>("engine_256x256x128_uint8.raw", 256));
  // Haze ends at about 20, the aluminium's peak begins at about 110.
  EXPECT_GT(found.threshold, 30);
  EXPECT_LT(found.threshold, 100);
}

TEST(AutomaticTransfer, separatesTheWalnutFromAir) {
  SKIP_WITHOUT("walnut_128x96x114_uint16.raw");
  const auto found = analyse(histogramOfFile<uint16_t>("walnut_128x96x114_uint16.raw", 4096));
  EXPECT_GT(found.threshold, 2000);
  EXPECT_LT(found.threshold, 5500);
}

TEST(AutomaticTransfer, showsTheNucleonFromItsFaintRimOn) {
  SKIP_WITHOUT("nucleon.raw");
  const auto found = analyse(histogramOfFile<uint8_t>("nucleon.raw", 250));
  EXPECT_GT(found.threshold, 0);
  EXPECT_LT(found.threshold, 30);
}

}  // namespace
}  // namespace sluice
