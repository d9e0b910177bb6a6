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
  std::string text =
      fmt::format("size {},{},{}", chunk.size_vox.x, chunk.size_vox.y, chunk.size_vox.z);
  std::multiset<std::string> blocks;
  for (const BlockPosition position : chunk.blocks) {
    const TextureBlock& b = plan.blocks[position];
    blocks.insert(fmt::format("; time {} block {} axis {} voxels {},{},{} to {},{},{} at {},{},{}",
                              b.name.time, b.name.block, b.trimming_axis, b.voxels.lo.x,
                              b.voxels.lo.y, b.voxels.lo.z, b.voxels.hi.x, b.voxels.hi.y,
                              b.voxels.hi.z, b.at.x, b.at.y, b.at.z));
  }
  for (const std::string& block : blocks) text += block;
  return text;
}

TEST(ChunkNames, namesAreEqualWhereRecipesAre) {
  std::mt19937_64 random(1);
  ChunkNames names;
  std::map<std::string, ChunkName> name_of;
  std::map<ChunkName, std::string> recipe_of;
  size_t chunks = 0;
  VisibleBlocks last = randomVisibleBlocks(kLayout, 0.5, random);
  for (int trial = 0; trial < 30; ++trial) {
    // Half of the blocks as the last time, so that recipes come back.
    const VisibleBlocks other = randomVisibleBlocks(kLayout, 0.5, random);
    std::vector<ObjectBlock> mixed;
    for (const ObjectBlock& object : last.blocks)
      if (object.name.block % 2 == trial % 2) mixed.push_back(object);
    for (const ObjectBlock& object : other.blocks)
      if (object.name.block % 2 != trial % 2) mixed.push_back(object);
    std::sort(mixed.begin(), mixed.end(),
              [](const ObjectBlock& a, const ObjectBlock& b) { return a.name < b.name; });
    for (ObjectBlock& object : mixed) object.name.time = trial / 15;
    last = visibleBlocksOf(kLayout, mixed);
    for (const Algorithm algorithm :
         {Algorithm::kConventional, Algorithm::kTrimmed, Algorithm::kMerged}) {
      PlanOptions options = planOptions(kLayout, algorithm);
      options.time = trial / 15;
      const TexturePlan plan = planTextures(kLayout, last, kPage, options);
      const ChunkNameList found = names.namesOf(plan);
      ASSERT_EQ(found.size(), plan.chunks.size());
      for (const ChunkPosition i : found.indices()) {
        ++chunks;
        const std::string text = recipe(plan, plan.chunks[i]);
        EXPECT_EQ(name_of.emplace(text, found[i]).first->second, found[i]) << text;
        EXPECT_EQ(recipe_of.emplace(found[i], text).first->second, text);
      }
    }
  }
  EXPECT_EQ(names.count(), static_cast<int64_t>(name_of.size()));
  EXPECT_LT(name_of.size(), chunks);  // some came back
}

TEST(ChunkNames, theSamePlanGetsTheSameNames) {
  std::mt19937_64 random(2);
  ChunkNames names;
  const TexturePlan plan = planTextures(kLayout, randomVisibleBlocks(kLayout, 0.5, random), kPage,
                                        planOptions(kLayout, Algorithm::kMerged));
  const ChunkNameList first = names.namesOf(plan);
  EXPECT_EQ(std::set<ChunkName>(first.begin(), first.end()).size(), plan.chunks.size());
  EXPECT_EQ(names.namesOf(plan), first);
  EXPECT_EQ(names.count(), static_cast<int64_t>(first.size()));
}

TEST(ChunkNames, aTimeStepIsPartOfTheRecipe) {
  ChunkNames names;
  const PlanOptions options = planOptions(kLayout, Algorithm::kTrimmed);
  const auto first = names.namesOf(planTextures(kLayout, allBlack(kLayout), kPage, options));
  VisibleBlocks later = allBlack(kLayout);
  for (ObjectBlock& block : later.blocks) block.name.time = 1;
  const auto second = names.namesOf(planTextures(kLayout, later, kPage, options));
  for (const ChunkPosition i : first.indices()) EXPECT_NE(first[i], second[i]);
}

TEST(ChunkNames, whatIsDrawnOfABlockIsNoPartOfItsRecipe) {
  // Clipping changes the cells, not the texels.
  std::mt19937_64 random(3);
  ChunkNames names;
  const VisibleBlocks some = randomVisibleBlocks(kLayout, 1, random);
  EXPECT_EQ(
      names.namesOf(planTextures(kLayout, some, kPage, planOptions(kLayout, Algorithm::kClipped))),
      names.namesOf(planTextures(kLayout, allBlack(kLayout), kPage,
                                 planOptions(kLayout, Algorithm::kConventional))));
}

TEST(ChunkNames, forgottenRecipesGetNewNames) {
  ChunkNames names;
  const PlanOptions options = planOptions(kLayout, Algorithm::kTrimmed);
  const TexturePlan plan = planTextures(kLayout, allBlack(kLayout), kPage, options);
  const auto first = names.namesOf(plan);
  names.forgetUnused([](ChunkName name) { return name.value() % 2 == 0; });
  EXPECT_EQ(names.kept(), (first.size() + 1) / 2);
  const auto again = names.namesOf(plan);
  for (const ChunkPosition i : first.indices()) {
    if (first[i].value() % 2 == 0) {
      EXPECT_EQ(again[i], first[i]);
    } else {
      EXPECT_GE(again[i].value(), static_cast<int64_t>(first.size()))
          << "never one that another recipe had";
    }
  }
  EXPECT_EQ(names.kept(), first.size());
}

}  // namespace
}  // namespace sluice
