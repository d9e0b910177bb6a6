// Ranks that share a volume in memory: what they refuse, and that a failure at one ends the call at
// all.
#include <sluice/in_situ.h>

#include <gmock/gmock.h>

#include "tests/library/in_situ_ranks.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

TEST(InSitu, wholeBlocksAreRefused) {
  const Field field({40, 40, 40});
  const std::vector<Box3> boxes = {{{0, 0, 0}, {20, 40, 40}}, {{20, 0, 0}, {40, 40, 40}}};
  RendererOptions machine = onCpu();
  machine.pipeline.algorithm = "conventional";
  EXPECT_THAT(drawInSitu(field, boxes, {}, {}, 1, 2, machine).failures,
              Each(HasSubstr("pipeline.algorithm conventional draws blocks whole")));
}

TEST(InSitu, lightThatLooksAroundIsRefused) {
  const Field field({40, 40, 40});
  const std::vector<Box3> boxes = {{{0, 0, 0}, {20, 40, 40}}, {{20, 0, 0}, {40, 40, 40}}};
  const LookOptions lit{.threshold = 2600, .light = LookOptions::Light::kOn};
  for (const PictureOptions::Lighting& lighting :
       {PictureOptions::Lighting{.shadows = 0.5}, PictureOptions::Lighting{.occlusion = 0.5}}) {
    PictureOptions picture = pictureFrom(30, false);
    picture.lighting = lighting;
    EXPECT_THAT(drawInSitu(field, boxes, lit, {picture}).failures,
                Each(HasSubstr("lighting.shadows and lighting.occlusion need the whole volume")));
    EXPECT_THAT(drawInSitu(field, {boxOf(field.size())}, lit, {picture}).failures, Each(""));
  }
}

TEST(InSitu, boxesThatAreNoPartitionAreOneLineAtEveryRank) {
  const Field field({40, 40, 40});
  const auto failuresOf = [&](const std::vector<Box3>& boxes) {
    return drawInSitu(field, boxes, {}, {}).failures;
  };
  EXPECT_THAT(failuresOf({{{0, 0, 0}, {20, 40, 40}}, {{22, 0, 0}, {40, 40, 40}}}),
              Each(HasSubstr("the ranks lend 60800 of 64000 voxels")));
  EXPECT_THAT(failuresOf({{{0, 0, 0}, {22, 40, 40}}, {{20, 0, 0}, {40, 40, 40}}}),
              Each(HasSubstr("cannot be put in order")));
  EXPECT_THAT(failuresOf({{{0, 0, 0}, {20, 40, 40}}, {{20, 0, 0}, {41, 40, 40}}}),
              Each(HasSubstr("rank 1 lends the box")));
  EXPECT_THAT(failuresOf({{{0, 0, 0}, {39, 40, 40}}, {{39, 0, 0}, {40, 40, 40}}}),
              Each(HasSubstr("expected at least 2")));
  // A pinwheel around a middle one: no plane parts them.
  EXPECT_THAT(failuresOf({{{0, 0, 0}, {25, 15, 40}},
                          {{25, 0, 0}, {40, 25, 40}},
                          {{15, 25, 0}, {40, 40, 40}},
                          {{0, 15, 0}, {15, 40, 40}},
                          {{15, 15, 0}, {25, 25, 40}}}),
              Each(HasSubstr("cannot be put in order")));
}

TEST(InSitu, missingGhostsAreOneLine) {
  const Field field({40, 40, 40});
  const std::vector<Box3> boxes = {{{0, 0, 0}, {20, 40, 40}}, {{20, 0, 0}, {40, 40, 40}}};
  EXPECT_THAT(drawInSitu(field, boxes, {}, {}, 0, 0).failures,
              Each(AllOf(HasSubstr("rank 0 of 2"), HasSubstr("lend one layer of ghosts above"))));
  const std::vector<PictureOptions> pictures = {pictureFrom(30, false)};
  const LookOptions lit{.threshold = 2600, .light = LookOptions::Light::kOn};
  EXPECT_THAT(drawInSitu(field, boxes, lit, pictures, 0, 1).failures,
              Each(HasSubstr("need one layer of ghosts below and two above")));
  const LookOptions plain{.threshold = 2600, .light = LookOptions::Light::kOff};
  const Drawn drawn = drawInSitu(field, boxes, plain, pictures, 0, 1);
  EXPECT_THAT(drawn.failures, Each(""));
  const Volume whole = Volume::borrow(field.voxels.data(), field.layout());
  Renderer renderer(whole, plain, onCpu());
  EXPECT_LE(largestDifference(drawn.images.at(0), renderer.draw(pictures[0])), 1.0 / 255);
}

// A failure at one rank is one at all, and the next picture is right.
TEST(InSitu, aFailureAtOneRankEndsTheCallAtAll) {
  const Field field({40, 40, 40});
  const std::vector<Box3> boxes = {{{0, 0, 0}, {20, 40, 40}}, {{20, 0, 0}, {40, 40, 40}}};
  std::vector<std::unique_ptr<Communicator>> ranks = inProcessRanks(2);
  std::vector<std::thread> threads;
  for (size_t rank = 0; rank < 2; ++rank)
    threads.emplace_back([&, rank] {
      const Part part(field, boxes[rank], 1, 2);
      const Volume volume = Volume::borrow(part.voxels.data(), field.layout(), part.box,
                                           ranksOf(std::move(ranks[rank])));
      Renderer renderer(volume, {.threshold = 2600}, onCpu());
      PictureOptions picture = pictureFrom(30, false);
      if (rank == 1) picture.width = 60;
      std::string said;
      try {
        renderer.draw(picture);
      } catch (const Error& error) {
        said = error.what();
      }
      EXPECT_THAT(said, AllOf(HasSubstr("rank 1 of 2"), HasSubstr("the size is 60x100")));
      picture.width = 120;
      EXPECT_EQ(renderer.draw(picture).width, rank == 0 ? 120 : 0);
      EXPECT_THROW(renderer.plan(picture), Error);
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace sluice
