// The levels that a volume is opened with: a case a row.
#include "src/library/opening/levels/level_choice.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "src/base/sources/level_kinds.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

constexpr double zero(int64_t, Vec3i) {
  return 0;
}

// A volume with levels of a file, and with others beside them, none of which is ever read.
class LeveledFile final : public FunctionSource, public LeveledSource, public LevelKinds {
 public:
  struct Kinds {
    std::vector<LevelValues> own = {}, beside = {};
    bool have_spreads = false, are_computed = false;
    int distant_reads = 0;
  };
  LeveledFile(Vec3i dims, const Kinds& kinds)
      : FunctionSource(functionLayout(dims, VoxelType::kU8), zero),
        distant_reads_(kinds.distant_reads) {
    const auto add = [&](LevelValues values, std::vector<CoarserLevel>& to) {
      const double scale = 2 << to.size();
      const Vec3i level_dims = dims / (int64_t{2} << to.size());
      sources_.push_back(
          std::make_unique<FunctionSource>(functionLayout(level_dims, VoxelType::kU8), zero));
      VolumeSource* const source = sources_.back().get();
      to.push_back({source,
                    {{scale, scale, scale}, {}},
                    kinds.have_spreads ? source : nullptr,
                    kinds.are_computed,
                    values});
    };
    for (const LevelValues values : kinds.own) add(values, own_);
    for (const LevelValues values : kinds.beside) add(values, beside_);
  }
  std::span<const CoarserLevel> levelsAbove() const override { return own_; }
  std::span<const CoarserLevel> levelsOfKind(LevelValues values) const override {
    if (beside_.empty() || beside_.front().values != values) return {};
    return beside_;
  }
  int distantReads() const override { return distant_reads_; }

 private:
  const int distant_reads_;
  std::vector<std::unique_ptr<VolumeSource>> sources_;
  std::vector<CoarserLevel> own_, beside_;
};

using enum LevelValues;
constexpr Vec3i kSmallDims{64, 64, 64}, kLargeDims{1024, 1024, 512};

struct Case {
  std::string what;
  LeveledFile::Kinds kinds;
  IndexNeeds needs;
  LevelsWish wish = LevelsWish::kAuto;
  Vec3i dims = kLargeDims;
  // Expected.
  std::vector<LevelValues> drawn_from = {};  // levels of the file
  LevelsWish beside = LevelsWish::kNone;
  bool own_suit = true, may_sample = false;
};

IndexNeeds needing(LevelNeeds levels, LevelValues values = kMeans) {
  return {.levels = levels, .values = values};
}
// The needs of a picture with a time limit.
IndexNeeds hurried(LevelNeeds levels, LevelValues values = kMeans) {
  return {.levels = levels, .values = values, .may_stand_in = true, .sample_seconds = 0.3};
}

TEST(LevelChoice, followsFromTheNeedsAndTheLevelsOfTheFile) {
  const LeveledFile::Kinds none, means{.own = {kMeans, kMeans}, .have_spreads = true},
      plain_means{.own = {kMeans, kMeans}}, unknown{.own = {kUnknown, kUnknown}},
      maxima{.own = {kMaxima}}, both{.own = {kMeans}, .beside = {kMaxima}, .have_spreads = true},
      computed{.own = {kMeans}, .have_spreads = true, .are_computed = true};
  const auto kFinest = LevelNeeds::kFinest, kFaithful = LevelNeeds::kFaithful,
             kAll = LevelNeeds::kAll;
  const auto kAuto = LevelsWish::kAuto, kAlways = LevelsWish::kAlways, kKept = LevelsWish::kKept,
             kNone = LevelsWish::kNone;
  const std::vector<Case> cases{
      {.what = "level 0 alone", .kinds = means, .needs = needing(kFinest)},
      {.what = "level 0 of a file without levels",
       .kinds = none,
       .needs = needing(kFinest),
       .wish = kAlways},
      {.what = "no levels, the default picture",
       .kinds = none,
       .needs = needing(kFaithful),
       .beside = kAuto},
      {.what = "no levels are wished", .kinds = none, .needs = needing(kAll), .wish = kNone},
      {.what = "means with spreads show what level 0 shows",
       .kinds = means,
       .needs = needing(kFaithful),
       .drawn_from = {kMeans, kMeans}},
      {.what = "means alone do not", .kinds = plain_means, .needs = needing(kFaithful)},
      {.what = "means alone on request, continued",
       .kinds = plain_means,
       .needs = needing(kAll),
       .drawn_from = {kMeans, kMeans},
       .beside = kAuto},
      {.what = "unknown levels are no faithful ones",
       .kinds = unknown,
       .needs = needing(kFaithful)},
      {.what = "unknown levels are taken for means on request",
       .kinds = unknown,
       .needs = needing(kAll),
       .drawn_from = {kUnknown, kUnknown},
       .beside = kAuto},
      {.what = "unknown levels are no maxima",
       .kinds = unknown,
       .needs = needing(kAll, kMaxima),
       .drawn_from = {kUnknown, kUnknown},
       .beside = kAuto,
       .own_suit = false},
      {.what = "maxima for a MIP",
       .kinds = maxima,
       .needs = needing(kFaithful, kMaxima),
       .drawn_from = {kMaxima}},
      {.what = "means where maxima are needed",
       .kinds = means,
       .needs = needing(kFaithful, kMaxima),
       .beside = kAuto,
       .own_suit = false},
      {.what = "maxima beside the means",
       .kinds = both,
       .needs = needing(kFaithful, kMaxima),
       .drawn_from = {kMaxima}},
      {.what = "labels are not continued",
       .kinds = {.own = {kModes}},
       .needs = needing(kAll, kModes),
       .drawn_from = {kModes}},
      {.what = "computed levels are not continued",
       .kinds = computed,
       .needs = needing(kAll),
       .drawn_from = {kMeans}},
      {.what = "a picture in a hurry does not wait for maxima",
       .kinds = means,
       .needs = hurried(kFaithful, kMaxima),
       .beside = kKept,
       .own_suit = false},
      {.what = "but for levels that the user wants always",
       .kinds = means,
       .needs = hurried(kFaithful, kMaxima),
       .wish = kAlways,
       .beside = kAlways,
       .own_suit = false},
      {.what = "a hurried picture of a large volume without levels takes a sample",
       .kinds = none,
       .needs = hurried(kAll),
       .beside = kKept,
       .may_sample = true},
      {.what = "a small one does not",
       .kinds = none,
       .needs = hurried(kAll),
       .dims = kSmallDims,
       .beside = kAuto},
      {.what = "nor one without levels by wish",
       .kinds = none,
       .needs = hurried(kAll),
       .wish = kNone},
      {.what = "nor one whose coarsest level is small",
       .kinds = plain_means,
       .needs = hurried(kAll),
       .dims = kSmallDims,
       .drawn_from = {kMeans, kMeans},
       .beside = kAuto},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.what);
    const auto source = withLevelsFor(std::make_unique<LeveledFile>(c.dims, c.kinds), c.needs);
    const LevelChoice choice = chooseLevels(*source, c.needs, c.wish);
    EXPECT_EQ(choice.own_suit, c.own_suit);
    EXPECT_EQ(choice.beside, c.beside);
    EXPECT_EQ(choice.may_sample, c.may_sample);
    std::vector<LevelValues> drawn_from;
    for (const CoarserLevel& level : levelsFor(*source, c.needs))
      drawn_from.push_back(level.values);
    EXPECT_EQ(drawn_from, c.drawn_from);
    EXPECT_EQ(source->storedBytesRead(), 0U);
  }
}

TEST(LevelChoice, aVolumeWithoutLevelsHasOneLevel) {
  const auto one = withoutLevels(std::make_unique<LeveledFile>(
      kSmallDims, LeveledFile::Kinds{.own = {kMeans, kMeans}, .have_spreads = true}));
  EXPECT_EQ(one->layout().levels, 1);
  EXPECT_TRUE(coarserLevels(*one).empty());
}

TEST(LevelChoice, extremesSwapWhereValuesFallAsNumbersRise) {
  const auto stored = [](LevelValues values, double scale) {
    ValueMap map;
    map.scale = scale;
    return storedNeeds({.values = values}, map).values;
  };
  EXPECT_EQ(stored(kMaxima, 2), kMaxima);
  EXPECT_EQ(stored(kMaxima, -1), kMinima);
  EXPECT_EQ(stored(kMinima, -1), kMaxima);
  EXPECT_EQ(stored(kMeans, -1), kMeans);
  EXPECT_EQ(stored(kModes, -1), kModes);
}

TEST(LevelChoice, volumesThatTakeLongToPassOverAreOpenedSoon) {
  struct Row {
    std::string what;
    LeveledFile::Kinds kinds;
    Vec3i dims;
    bool is_hurried;
  };
  const std::vector<Row> rows{
      {"large, unknown levels", {.own = {kUnknown}}, kLargeDims, true},
      {"large, means with spreads", {.own = {kMeans}, .have_spreads = true}, kLargeDims, true},
      {"large, maxima only", {.own = {kMaxima}}, kLargeDims, false},
      {"large, no levels", {}, kLargeDims, false},
      {"large, computed levels", {.own = {kMeans}, .are_computed = true}, kLargeDims, false},
      {"small", {.own = {kUnknown}}, kSmallDims, false},
      {"small and far away", {.own = {kUnknown}, .distant_reads = 8}, kSmallDims, true},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.what);
    const LeveledFile source(row.dims, row.kinds);
    IndexNeeds needs = kUsualNeeds;
    EXPECT_FALSE(hurriedNeeds(needs, source).may_stand_in) << "nobody is in a hurry";
    needs.opens_soon = true;
    const IndexNeeds hurried = hurriedNeeds(needs, source);
    EXPECT_EQ(hurried.may_stand_in, row.is_hurried);
    EXPECT_EQ(hurried.levels, row.is_hurried ? LevelNeeds::kAll : LevelNeeds::kFaithful);
    needs.levels = LevelNeeds::kFinest;
    EXPECT_EQ(hurriedNeeds(needs, source).levels, LevelNeeds::kFinest);
  }
}

}  // namespace
}  // namespace sluice
