// The updates of a frame by hand, and the number of them under performances that are known.
#include "src/visibility/occlusion/map_updates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>

namespace sluice {
namespace {

TEST(UpdateSchedule, anUpdateAfterEachShareOfTheVoxels) {
  UpdateSchedule schedule(1000, 3);  // after 250, 500, 750
  EXPECT_FALSE(schedule.isDueAfter(249));
  EXPECT_TRUE(schedule.isDueAfter(1));
  EXPECT_FALSE(schedule.isDueAfter(200));
  EXPECT_TRUE(schedule.isDueAfter(100));
  EXPECT_FALSE(schedule.isDueAfter(0));
  EXPECT_EQ(schedule.updates(), 2);
}

TEST(UpdateSchedule, aBoxLargerThanAShareIsFollowedByOneUpdate) {
  UpdateSchedule schedule(1000, 9);  // after 100, 200, ...
  EXPECT_TRUE(schedule.isDueAfter(450));
  EXPECT_FALSE(schedule.isDueAfter(49));
  EXPECT_TRUE(schedule.isDueAfter(1));
  EXPECT_EQ(schedule.updates(), 2);
}

TEST(UpdateSchedule, nothingIsUpdatedAfterTheLastVoxel) {
  UpdateSchedule schedule(1000, 3);
  EXPECT_TRUE(schedule.isDueAfter(999));
  EXPECT_FALSE(schedule.isDueAfter(1));
}

TEST(UpdateSchedule, noUpdatesAreNever) {
  UpdateSchedule none(1000, 0), empty(0, 5);
  EXPECT_FALSE(none.isDueAfter(1000));
  EXPECT_FALSE(empty.isDueAfter(0));
}

// Runs frames whose share of skipped voxels is a function of the number of updates.
void run(UpdateCount& count, int frames, const std::function<double(int)>& skipped) {
  for (int i = 0; i < frames; ++i) {
    const int updates = count.next();
    count.finished({skipped(updates), updates});
  }
}

TEST(UpdateCount, startsWithThePapersNumberAndPollsEachTenthFrame) {
  UpdateCount count;
  std::multiset<int> polled;
  for (int frame = 1; frame <= 60; ++frame) {
    if (frame % 10 == 0) {
      polled.insert(count.next());
    } else {
      EXPECT_EQ(count.next(), 9) << "frame " << frame;
    }
    count.finished({0.5, 9});
  }
  EXPECT_EQ(polled, (std::multiset<int>{6, 7, 8, 10, 11, 12})) << "each other number once";
}

TEST(UpdateCount, performanceIsTheShareSkippedLessTheCostOfTheUpdates) {
  UpdateCount count;
  count.finished({0.5, 7});
  ASSERT_TRUE(count.performance(9));
  EXPECT_DOUBLE_EQ(*count.performance(9), 0.5 - 0.02 * 7);
  EXPECT_FALSE(count.performance(8)) << "never polled";
  EXPECT_FALSE(count.performance(13)) << "outside the window";
}

// With v = 1 - exp(-k / tau), p rises until exp(-k / tau) / tau = 0.02: to k = tau ln(50 / tau).
TEST(UpdateCount, climbsToTheBestNumberAndStays) {
  const auto skipped = [](double tau) { return [tau](int k) { return 1 - std::exp(-k / tau); }; };
  UpdateCount count;
  run(count, 3000, skipped(16));
  EXPECT_NEAR(count.center(), 16 * std::log(50.0 / 16), 1);
  const int settled = count.center();
  run(count, 1000, skipped(16));
  EXPECT_EQ(count.center(), settled);
  run(count, 3000, skipped(2));
  EXPECT_NEAR(count.center(), 2 * std::log(25.0), 1) << "another view, another number";
}

TEST(UpdateCount, aFlatPerformanceDoesNotDrift) {
  UpdateCountOptions options;
  options.update_cost = 0;
  UpdateCount count(options);
  run(count, 2000, [](int) { return 0.6; });
  EXPECT_EQ(count.center(), 9);
}

TEST(UpdateCount, staysWithinItsBounds) {
  UpdateCountOptions options;
  options.most = 12;
  UpdateCount more(options);
  run(more, 3000, [](int k) {
    EXPECT_LE(k, 12);
    return 0.1 * k;
  });
  EXPECT_EQ(more.center(), 12);
  UpdateCount fewer(options);
  run(fewer, 3000, [](int k) {
    EXPECT_GE(k, 1);
    return 0.5;
  });
  EXPECT_EQ(fewer.center(), 1) << "updates that bring nothing cost";
}

TEST(UpdateCount, slotsThatAreTooOldDoNotCount) {
  UpdateCountOptions options;
  options.oldest = 2;  // polls: the window of seven is never valid as a whole
  UpdateCount count(options);
  run(count, 2000, [](int k) { return 0.1 * k; });
  EXPECT_EQ(count.center(), 9);
  int valid = 0;
  for (int k = 6; k <= 12; ++k) valid += count.performance(k) ? 1 : 0;
  EXPECT_LE(valid, 4);
}

}  // namespace
}  // namespace sluice
