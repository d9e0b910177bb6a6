#include "src/texture/chunk_names.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/texture/random_plan.h"

namespace sluice {
namespace {

const PageGeometry kPage{{8, 8, 1}, 1, 64};
const BlockLayout kLayout = blockLayout({50, 36, 43}, 8, 0);

// All that the texels of a chunk follow from, spelled out.
std::string recipe(const TexturePlan& plan, const Chunk& chunk) {
  std::string text = fmt::format("time {} size {},{},{}", plan.time, chunk.size_vox.x,
                                 chunk.size_vox.y, chunk.size_vox.z);
  std::multiset<std::string> blocks;
  for (const int64_t position : chunk.blocks) {
    const TextureBlock& b = plan.blocks[static_cast<size_t>(position)];
    blocks.insert(fmt::format("; block {} axis {} voxels {},{},{} to {},{},{} at {},{},{}", b.block,
                              b.trimming_axis, b.voxels.lo.x, b.voxels.lo.y, b.voxels.lo.z,
                              b.voxels.hi.x, b.voxels.hi.y, b.voxels.hi.z, b.at.x, b.at.y, b.at.z));
  }
  for (const std::string& block : blocks) text += block;
  return text;
}

TEST(ChunkNames, namesAreEqualWhereRecipesAre) {
  std::mt19937_64 random(1);
  ChunkNames names;
  std::map<std::string, uint64_t> name_of;
  std::map<uint64_t, std::string> recipe_of;
  size_t chunks = 0;
  Classification last = randomClassification(kLayout, 0.5, random);
  for (int trial = 0; trial < 30; ++trial) {
    // Half of the blocks as the last time, so that recipes come back.
    const Classification other = randomClassification(kLayout, 0.5, random);
    std::vector<ObjectBlock> mixed;
    for (const ObjectBlock& object : last.visible)
      if (object.block % 2 == trial % 2) mixed.push_back(object);
    for (const ObjectBlock& object : other.visible)
      if (object.block % 2 != trial % 2) mixed.push_back(object);
    std::sort(mixed.begin(), mixed.end(),
              [](const ObjectBlock& a, const ObjectBlock& b) { return a.block < b.block; });
    last = classificationOf(kLayout, mixed);
    for (const Algorithm algorithm :
         {Algorithm::kConventional, Algorithm::kTrimmed, Algorithm::kMerged}) {
      PlanOptions options = planOptions(kLayout, algorithm);
      options.time = trial / 15;
      const TexturePlan plan = planTextures(kLayout, last, kPage, options);
      const std::vector<uint64_t> found = names.namesOf(plan);
      ASSERT_EQ(found.size(), plan.chunks.size());
      for (size_t i = 0; i < found.size(); ++i, ++chunks) {
        const std::string text = recipe(plan, plan.chunks[i]);
        EXPECT_EQ(name_of.emplace(text, found[i]).first->second, found[i]) << text;
        EXPECT_EQ(recipe_of.emplace(found[i], text).first->second, text);
      }
    }
  }
  EXPECT_EQ(names.count(), name_of.size());
  EXPECT_LT(name_of.size(), chunks);  // some came back
}

TEST(ChunkNames, theSamePlanGetsTheSameNames) {
  std::mt19937_64 random(2);
  ChunkNames names;
  const TexturePlan plan = planTextures(kLayout, randomClassification(kLayout, 0.5, random), kPage,
                                        planOptions(kLayout, Algorithm::kMerged));
  const std::vector<uint64_t> first = names.namesOf(plan);
  EXPECT_EQ(std::set<uint64_t>(first.begin(), first.end()).size(), plan.chunks.size());
  EXPECT_EQ(names.namesOf(plan), first);
  EXPECT_EQ(names.count(), first.size());
}

TEST(ChunkNames, aTimeStepIsPartOfTheRecipe) {
  ChunkNames names;
  PlanOptions options = planOptions(kLayout, Algorithm::kTrimmed);
  const auto first = names.namesOf(planTextures(kLayout, allBlack(kLayout), kPage, options));
  options.time = 1;
  const auto second = names.namesOf(planTextures(kLayout, allBlack(kLayout), kPage, options));
  for (size_t i = 0; i < first.size(); ++i) EXPECT_NE(first[i], second[i]);
}

TEST(ChunkNames, whatIsDrawnOfABlockIsNoPartOfItsRecipe) {
  // Clipping changes the cells, not the texels.
  std::mt19937_64 random(3);
  ChunkNames names;
  const Classification some = randomClassification(kLayout, 1, random);
  EXPECT_EQ(
      names.namesOf(planTextures(kLayout, some, kPage, planOptions(kLayout, Algorithm::kClipped))),
      names.namesOf(planTextures(kLayout, allBlack(kLayout), kPage,
                                 planOptions(kLayout, Algorithm::kConventional))));
}

}  // namespace
}  // namespace sluice
