// Channels blended as one medium from one cut through their levels of resolution.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "src/render/session/blended_frame.h"
#include "tests/render/blended_plainly.h"
#include "tests/render/level_scene.h"
#include "tests/support/reference_values.h"

namespace sluice {
namespace {

constexpr Vec3i kSize{96, 81, 75};

TransferFunction between(Vec3d dark, Vec3d bright, double threshold, double most) {
  TransferFunction transfer;
  transfer.colors = {{threshold, dark}, {255, bright}};
  transfer.opacities = {{threshold, 0}, {threshold + 40, most}, {255, most}};
  transfer.name = "channel";
  return transfer;
}
TransferFunction nothing() {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = {{0, 0}, {255, 0}};
  return transfer;
}

std::unique_ptr<MemorySource> blobsOf(uint64_t seed) {
  return makeSparseBlobs({.dims = kSize, .type = VoxelType::kU8, .seed = seed, .blobs = 25});
}

class BlendedLevelsTest : public LevelCutTest {
 protected:
  explicit BlendedLevelsTest(Spreads spreads = Spreads::kNone)
      : first_source_(blobsOf(3)),
        second_source_(blobsOf(8)),
        first_(*first_source_, 3, false, spreads),
        second_(*second_source_, 3, false, spreads) {
    options_.size = {59, 47};
    options_.camera.azimuth_deg = 35;
    options_.camera.elevation_deg = 20;
  }
  // The blended picture of both volumes.
  Drawn blended(const TransferFunction& of_first, const TransferFunction& of_second) {
    if (sessions_.empty()) {
      sessions_.push_back(sessionOf(first_, of_first));
      sessions_.push_back(sessionOf(second_, of_second));
    }
    std::vector<Session*> sessions;
    for (const auto& session : sessions_) {
      session->setOptions(options_);
      sessions.push_back(session.get());
    }
    made_ = Session::parts(sessions);
    std::vector<FrameReport> reports;
    Frame frame = blendedFrame(made_, device(), reports);
    FloatPicture picture;
    picture.width = frame.picture.width;
    picture.height = frame.picture.height;
    picture.rgba = std::move(frame.picture.rgba);
    return {std::move(picture), frame.report};
  }

  const std::unique_ptr<MemorySource> first_source_, second_source_;
  Pyramid first_, second_;
  FrameOptions options_;
  std::vector<std::unique_ptr<Session>> sessions_;
  Session::Parts made_;
};

class BlendedSpreadsTest : public BlendedLevelsTest {
 protected:
  BlendedSpreadsTest() : BlendedLevelsTest(Spreads::kKept) {}
};

// A level's value at a position in the finest level's index space.
PlainChannel channelOf(const CoarserLevel& level, const TransferFunction& look) {
  const auto values = std::make_shared<const ReferenceValues>(*level.source, 0);
  return {[values, &level](Vec3d p) {
            Vec3d at = level.placement.levelFromFinest(p);
            const Vec3i dims = level.source->layout().dims;
            for (int a = 0; a < 3; ++a)
              at[a] = std::clamp(at[a], 0.0, static_cast<double>(dims[a] - 1));
            return values->at(at);
          },
          look};
}

TEST_F(BlendedLevelsTest, aLevelIsTheRuleInPlainLoopsOverItsVoxels) {
  const std::vector<TransferFunction> looks{between({1, 0.2, 0}, {1, 0.9, 0}, 30, 0.3),
                                            between({0, 0.2, 1}, {0.1, 0.9, 0.6}, 20, 0.2)};
  for (const int level : {1, 2})
    for (const Projection projection : kProjections) {
      options_.camera.projection = projection;
      options_.cut = CutOptions{.level = level};
      const auto at = static_cast<size_t>(level) - 1;
      const FloatPicture plain = blendedPlainly({channelOf(first_.means.levels()[at], looks[0]),
                                                 channelOf(second_.means.levels()[at], looks[1])},
                                                kSize, viewOf(first_, options_));
      EXPECT_GT(shownShare(plain), 0.05);
      EXPECT_TRUE(within(1, blended(looks[0], looks[1]).picture, plain)) << level;
    }
}

// Whatever the levels of the cut are.
TEST_F(BlendedSpreadsTest, withAChannelThatShowsNothingItIsTheOther) {
  const TransferFunction of_first = between({1, 0.2, 0}, {1, 0.9, 0}, 30, 0.3);
  const auto alone = sessionOf(first_, of_first);
  for (const Projection projection : kProjections)
    for (const double pixel_error : {0.3, 1.0, 3.0}) {
      options_.camera.projection = projection;
      options_.camera.zoom = projection == Projection::kPerspective ? 3 : 1;
      options_.cut = CutOptions{.pixel_error = pixel_error};
      const Drawn other = draw(*alone, options_);
      const Drawn both = blended(of_first, nothing());
      EXPECT_GT(shownShare(other.picture), 0.05);
      EXPECT_TRUE(within(1, both.picture, other.picture)) << pixel_error;
      ASSERT_TRUE(both.report.cut);
      EXPECT_EQ(both.report.cut->levels.size(), other.report.cut->levels.size());
      EXPECT_TRUE(both.report.cut->spread.has_value() == other.report.cut->spread.has_value());
    }
}

TEST_F(BlendedSpreadsTest, allChannelsAreOfOneCut) {
  const TransferFunction of_first = between({1, 0.2, 0}, {1, 0.9, 0}, 30, 0.3);
  const TransferFunction of_second = between({0, 0.2, 1}, {0.1, 0.9, 0.6}, 120, 0.2);
  options_.camera.projection = Projection::kPerspective;
  options_.camera.zoom = 4;
  options_.cut = CutOptions{.pixel_error = 1};
  for (const bool keeps_thin : {false, true}) {
    options_.cut->keeps_thin = keeps_thin;
    blended(of_first, of_second);
    std::set<int32_t> levels;
    const VisibleBlocks &a = *made_.of_sessions[0].visible, &b = *made_.of_sessions[1].visible;
    expectPartition(first_, a);
    expectPartition(second_, b);
    int alike = 0;
    for (const ObjectBlock& of_a : a.blocks)
      for (const ObjectBlock& of_b : b.blocks) {
        const Box3 shared =
            intersect(first_.layout().regionOf(of_a.name), second_.layout().regionOf(of_b.name));
        if (shared.empty()) continue;
        EXPECT_EQ(of_a.name.level, of_b.name.level);
        EXPECT_EQ(of_a.name.block, of_b.name.block);
        levels.insert(of_a.name.level);
        ++alike;
      }
    EXPECT_GT(alike, 5);
    EXPECT_GT(levels.size(), 1U);
  }
}

// A channel's limit stops the refinement of all.
TEST_F(BlendedSpreadsTest, theTightestBudgetHoldsForAll) {
  const TransferFunction of_first = between({1, 0.2, 0}, {1, 0.9, 0}, 30, 0.3);
  const TransferFunction of_second = between({0, 0.2, 1}, {0.1, 0.9, 0.6}, 20, 0.2);
  options_.cut = CutOptions{.pixel_error = 0.1};
  blended(of_first, of_second);
  const auto heldBytes = [&](size_t channel) {
    uint64_t bytes = 0;
    const Pyramid& pyramid = channel == 0 ? first_ : second_;
    for (const ObjectBlock& block : made_.of_sessions[channel].visible->blocks)
      bytes += static_cast<uint64_t>(pyramid.layout().storedVoxels(block.name).count() *
                                     pyramid.layout().of(block.name).numbers);
    return bytes;
  };
  const uint64_t all_bytes = heldBytes(1);
  EXPECT_TRUE(made_.of_sessions[0].visible->cut->is_final);
  FrameOptions tight = options_;
  tight.cut->most_held_bytes = all_bytes / 3;
  sessions_[0]->setOptions(options_);
  sessions_[1]->setOptions(tight);
  Session* const sessions[] = {sessions_[0].get(), sessions_[1].get()};
  made_ = Session::parts(sessions);
  EXPECT_LE(heldBytes(1), all_bytes / 3);
  for (const Session::Part& part : made_.of_sessions) {
    EXPECT_FALSE(part.visible->cut->is_final);
    EXPECT_GT(levelsOf(*part.visible).size(), 1U);
  }
}

// Pictures that may not wait for their data are coarse at first and then better, never in part.
TEST_F(BlendedSpreadsTest, gettingBetterEndsWithThePictureThatWaits) {
  const TransferFunction of_first = between({1, 0.2, 0}, {1, 0.9, 0}, 30, 0.3);
  const TransferFunction of_second = between({0, 0.2, 1}, {0.1, 0.9, 0.6}, 20, 0.2);
  options_.cut = CutOptions{.pixel_error = 0.3};
  const FloatPicture waited = blended(of_first, of_second).picture;
  sessions_.clear();
  options_.time_limit_s = 1e-9;  // nothing comes in time
  const Drawn first = blended(of_first, of_second);
  EXPECT_TRUE(first.report.cut->will_improve);
  EXPECT_EQ(first.report.missing_share, 0);
  for (const Session::Part& part : made_.of_sessions)
    EXPECT_EQ(levelsOf(*part.visible), std::set<int32_t>{first_.layout().levels() - 1});
  options_.time_limit_s = 0.2;  // each picture refines some part
  Drawn last = first;
  int pictures = 0;
  for (; last.report.cut->will_improve && pictures < 500; ++pictures)
    last = blended(of_first, of_second);
  EXPECT_FALSE(last.report.cut->will_improve);
  EXPECT_GT(pictures, 0);
  EXPECT_TRUE(within(1, last.picture, waited));
}

}  // namespace
}  // namespace sluice
