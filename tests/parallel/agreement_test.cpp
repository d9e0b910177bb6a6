// Ranks that would draw different things: all of them end with the line that names the rank and the
// difference.
#include "src/parallel/agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "src/base/threads/worker_pool.h"
#include "src/parallel/communication/in_process.h"
#include "tests/support/memory_source.h"

namespace sluice {
namespace {

using testing::Each;

// How so many ranks end, rank r with facts(r).
template <class Facts>
std::vector<std::string> ends(int ranks, const Facts& facts) {
  return runInProcess(ranks,
                      [&](Team& team) { expectAgreement(team, facts(team.rank()), "look again"); });
}

TEST(Agreement, ofRanksThatStateTheSame) {
  EXPECT_THAT(ends(3,
                   [](int rank) {
                     std::vector<Fact> facts{{"--block", "32"}, {"voxels", "", 7}};
                     if (rank == 1) std::swap(facts[0], facts[1]);
                     return facts;
                   }),
              Each(std::string()));
  EXPECT_THAT(ends(1, [](int) { return std::vector<Fact>{{"a", "b"}}; }), Each(std::string()));
}

TEST(Agreement, namesTheRankAndWhatDiffers) {
  EXPECT_THAT(
      ends(4,
           [](int rank) {
             return std::vector<Fact>{{"--block", rank == 2 ? "16" : "32"}, {"--frames", "1"}};
           }),
      Each(std::string("rank 2 of 4 would draw something else than rank 0: --block is 16, "
                       "on rank 0 32; look again")));
  EXPECT_THAT(ends(3,
                   [](int rank) {
                     std::vector<Fact> facts{{"voxels", "", rank > 0 ? 8U : 7U}};
                     if (rank == 0) facts.push_back({"--crop", "0:9"});
                     return facts;
                   }),
              Each(std::string("rank 1 of 3 would draw something else than rank 0 (and 1 more "
                               "ranks): voxels differ; --crop is not given, on rank 0 0:9; "
                               "look again")));
}

std::unique_ptr<MemorySource> sourceOf(const std::vector<uint8_t>& voxels, Vec3i dims) {
  VolumeLayout layout;
  layout.dims = dims;
  return memorySourceOf<uint8_t>(layout, voxels);
}

SliceRanges rangesOf(VolumeSource& source) {
  WorkerPool pool(1);
  ProgressMeter progress;
  return buildSliceRanges(source, 0, blockLayout(source.layout().dims, 8, 0), {pool, progress});
}

std::vector<Fact> factsOfVolume(const std::vector<uint8_t>& voxels, Vec3i dims) {
  const auto source = sourceOf(voxels, dims);
  return factsOf(*source, 0, rangesOf(*source), 16);
}

// A single voxel that differs is found by the min-max arrays if it is an extreme value of its
// planes.
TEST(Agreement, factsOfAVolumeDependOnItsVoxels) {
  const Vec3i dims{20, 12, 9};
  const std::vector<uint8_t> voxels(static_cast<size_t>(volume(dims)), 40);
  const auto facts = factsOfVolume(voxels, dims);
  const auto same = factsOfVolume(voxels, dims);
  std::vector<uint8_t> other_voxels = voxels;
  other_voxels[777] = 41;
  const auto other = factsOfVolume(other_voxels, dims);
  ASSERT_EQ(facts.size(), other.size());
  int differences = 0;
  for (size_t i = 0; i < facts.size(); ++i) {
    EXPECT_EQ(facts[i].digest, same[i].digest) << facts[i].name;
    differences += facts[i].digest != other[i].digest ? 1 : 0;
    EXPECT_EQ(facts[i].value, other[i].value) << facts[i].name;
  }
  EXPECT_GE(differences, 1);
}

// The sampled rows find voxels that differ between the same extremes, about which an index made
// from another copy tells nothing.
TEST(Agreement, sampledRowsFindAnotherCopyUnderTheSameIndex) {
  const Vec3i dims{64, 40, 40};
  std::vector<uint8_t> voxels(static_cast<size_t>(volume(dims)));
  for (size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<uint8_t>(i * 7 % 251);
  const auto source = sourceOf(voxels, dims);
  std::reverse(voxels.begin(), voxels.end());
  const auto copy = sourceOf(voxels, dims);
  const SliceRanges ranges = rangesOf(*source);
  const auto facts = factsOf(*source, 0, ranges, 4), other = factsOf(*copy, 0, ranges, 4);
  EXPECT_EQ(facts.back().name, "voxels");
  EXPECT_NE(facts.back().digest, other.back().digest);
}

}  // namespace
}  // namespace sluice
