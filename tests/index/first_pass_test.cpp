#include "src/index/first_pass.h"

#include <gmock/gmock.h>

#include "tests/support/error_of.h"
#include "tests/support/function_source.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

VolumeLayout layoutOf(Vec3i dims) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.name = "v";
  return layout;
}

// A source that holds so much a thread.
class HoldingSource final : public FunctionSource {
 public:
  HoldingSource(Vec3i dims, uint64_t held, std::optional<Occupancy> occupancy = std::nullopt)
      : FunctionSource(
            layoutOf(dims), [](int64_t, Vec3i) { return 0.0; }, occupancy),
        held_(held) {}
  uint64_t heldBytesAThread() const override { return held_; }

 private:
  const uint64_t held_;
};

// A listing may ask a server for each chunk.
TEST(FirstPass, asksOnceForWhatIsStored) {
  class Counting final : public FunctionSource {
   public:
    Counting() : FunctionSource(layoutOf({64, 64, 64}), [](int64_t, Vec3i) { return 0.0; }) {}
    std::optional<Occupancy> occupancy(int64_t /*time*/) override {
      ++asked;
      return Occupancy{0, {{{0, 0, 0}, {5, 5, 2}}}};
    }
    int asked = 0;
  } source;
  planFirstPass(source, 0, blockLayout(source.layout().dims, 64, 0), uint64_t{1} << 30, 2);
  EXPECT_EQ(source.asked, 1);
}

constexpr uint64_t kMiB = 1 << 20;

FirstPass passOf(HoldingSource& source, uint64_t memory_bytes) {
  return planFirstPass(source, 0, blockLayout(source.layout().dims, 64, 0), memory_bytes, 8);
}

TEST(FirstPass, allThreadsReadWhereThereIsRoom) {
  HoldingSource source({256, 256, 256}, 0);
  EXPECT_EQ(passOf(source, 512 * kMiB).threads, 8);
  EXPECT_EQ(passOf(source, 512 * kMiB).voxel_bytes, 128 * kMiB);
}

// Three quarters of 100 MiB hold three threads of 20 MiB and a block of half a MiB each.
TEST(FirstPass, asManyThreadsAsTheMemoryHoldsDecodeAtOnce) {
  HoldingSource source({256, 256, 256}, 20 * kMiB);
  const FirstPass pass = passOf(source, 100 * kMiB);
  EXPECT_EQ(pass.threads, 3);
  EXPECT_EQ(pass.voxel_bytes, 15 * kMiB);
  EXPECT_EQ(passOf(source, 21 * kMiB).threads, 1);
}

TEST(FirstPass, theLeastThatWorksIsNamedBeforeItIsTaken) {
  HoldingSource source({256, 256, 256}, 1000 * kMiB);
  EXPECT_THAT(errorOf([&] { passOf(source, 16 * kMiB); }),
              AllOf(testing::StartsWith("v: reading it takes 1000.5 MiB at a time"),
                    HasSubstr("--memory is 16.0 MiB; give --memory 1001M")));
  EXPECT_EQ(passOf(source, 1001 * kMiB).threads, 1);
}

TEST(FirstPass, theBudgetThatDrawsIsNamedWithIt) {
  HoldingSource source({256, 256, 256}, 1000 * kMiB);
  const BlockLayout layout = blockLayout(source.layout().dims, 64, 0);
  double arrays = 0;
  const auto enough = [&](const PassNeeds& needs) {
    arrays = needs.array_bytes;
    return PassBudgets{needs.least_bytes, 3000.0 * kMiB};
  };
  EXPECT_THAT(errorOf([&] { planFirstPass(source, 0, layout, 16 * kMiB, 8, enough); }),
              HasSubstr("; give --memory 1001M or more to look at it, and 3000M to draw it"));
  // 125 blocks of 64 voxels a side, whose 64 planes along each axis have two values each, and two
  // values for each of 64^3 bricks.
  EXPECT_GT(arrays, 125.0 * 2 * 3 * 64);
  EXPECT_LT(arrays, 126.0 * 2 * 3 * 68 + 2.0 * 64 * 64 * 64);
  planFirstPass(source, 0, layout, 1001 * kMiB, 8, enough);
}

TEST(FirstPass, arraysThatCannotFitAreRefusedUnlessTheVolumeIsKnownToBeEmptyThere) {
  const Vec3i dims{1'000'000, 1'000'000, 2};
  HoldingSource dense(dims, 0);
  EXPECT_THAT(errorOf([&] { passOf(dense, 1024 * kMiB); }),
              AllOf(HasSubstr("of min-max arrays"), HasSubstr("larger --block")));
  HoldingSource sparse(dims, 0, Occupancy{0, {{{0, 0, 0}, {5, 5, 2}}}});
  EXPECT_EQ(passOf(sparse, 64 * kMiB).threads, 8);
}

}  // namespace
}  // namespace sluice
