#include <sluice/in_situ.h>
#include <sluice/renderer.h>

#include <gmock/gmock.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <random>
#include <set>

#include "src/base/threads/clock.h"
#include "tests/library/in_situ_ranks.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

// Any number of ranks, of boxes that are no multiples of blocks, gives the picture of one process.
TEST(InSitu, ranksDrawThePictureOfOneProcess) {
  const Field field({97, 70, 83});
  const Volume whole = Volume::borrow(field.voxels.data(), field.layout());
  const std::vector<PictureOptions> pictures = {pictureFrom(30, false), pictureFrom(200, true),
                                                pictureFrom(-70, true)};
  struct Look {
    const char* name;
    LookOptions look;
  };
  std::vector<Look> looks;
  looks.push_back({"chosen", {}});
  looks.push_back({"lit", {.threshold = 2600, .opacity = 0.4, .light = LookOptions::Light::kOn}});
  looks.push_back({"fog", {.threshold = 500, .opacity = 0.02, .light = LookOptions::Light::kOff}});
  looks.push_back({"maximum", {.mode = LookOptions::Mode::kMaximum}});
  looks.push_back({"average", {.mode = LookOptions::Mode::kAverage}});
  for (const Look& look : looks) {
    std::vector<Image> alone;
    Renderer renderer(whole, look.look, onCpu());
    for (const PictureOptions& picture : pictures) alone.push_back(renderer.draw(picture));
    for (const int ranks : {1, 2, 4, 7}) {
      SCOPED_TRACE(testing::Message() << look.name << ", " << ranks << " ranks");
      const Drawn drawn = drawInSitu(field, bisected(field.size(), ranks, 5), look.look, pictures);
      EXPECT_THAT(drawn.failures, Each(""));
      ASSERT_EQ(drawn.images.size(), alone.size());
      for (size_t i = 0; i < alone.size(); ++i) {
        EXPECT_LE(largestDifference(drawn.images[i], alone[i]), 1.0 / 255) << "picture " << i;
        EXPECT_GT(largestDifference(drawn.images[i], drawn.images[(i + 1) % alone.size()]), 0.1);
      }
    }
  }
}

TEST(InSitu, eachWayOfThePipelineGivesThatPicture) {
  const Field field({97, 70, 83});
  const LookOptions look{.threshold = 2600, .opacity = 0.4};
  const std::vector<PictureOptions> pictures = {pictureFrom(30, true)};
  const std::vector<Box3> boxes = bisected(field.size(), 4, 5);
  const Drawn usual = drawInSitu(field, boxes, look, pictures);
  for (const PipelineOptions& pipeline :
       std::vector<PipelineOptions>{{.algorithm = "clipped"},
                                    {.partition = "boxes"},
                                    {.occlusion = "cull"},
                                    {.occlusion = "clip"},
                                    {.policy = "arc", .pages = 16}}) {
    SCOPED_TRACE(pipeline.algorithm + pipeline.partition + pipeline.occlusion + pipeline.policy);
    RendererOptions machine = onCpu();
    machine.pipeline = pipeline;
    PictureOptions picture = pictures.front();
    picture.opacity_threshold = 1;
    const Drawn drawn = drawInSitu(field, boxes, look, {picture}, 1, 2, machine);
    EXPECT_THAT(drawn.failures, Each(""));
    ASSERT_EQ(drawn.images.size(), 1U);
    EXPECT_LE(largestDifference(drawn.images[0], usual.images[0]), 1.0 / 255);
  }
}

// A plane with a spot between planes that show nothing.
TEST(InSitu, aCropOfOnePlaneIsFramedAsAWhole) {
  Field field({40, 36, 32});
  for (const int axis : {0, 1, 2})
    for (const int64_t plane : {int64_t{17}, field.size()[axis] - 1}) {
      SCOPED_TRACE(testing::Message() << "axis " << axis << ", plane " << plane);
      Vec3i at;
      for (at.z = 0; at.z < 32; ++at.z)
        for (at.y = 0; at.y < 36; ++at.y)
          for (at.x = 0; at.x < 40; ++at.x) {
            Vec3i away = at - Vec3i{15, 15, 15};
            away[axis] = 0;
            const bool is_spot = dot(toDouble(away), toDouble(away)) < 20;
            field.voxels[static_cast<size_t>((at.z * 36 + at.y) * 40 + at.x)] =
                at[axis] == plane && is_spot ? 3000 : 0;
          }
      const Volume whole = Volume::borrow(field.voxels.data(), field.layout());
      const LookOptions look{.threshold = 1000, .opacity = 1, .light = LookOptions::Light::kOff};
      PictureOptions picture = pictureFrom(30, false);
      picture.view.fit = ViewOptions::Fit::kVisible;
      picture.crop = PictureOptions::Box{{0, 0, 0}, field.dims};
      picture.crop->lo[static_cast<size_t>(axis)] = plane;
      picture.crop->hi[static_cast<size_t>(axis)] = plane + 1;
      const Image alone = Renderer(whole, look, onCpu()).draw(picture);
      for (const int ranks : {1, 4}) {
        const Drawn drawn = drawInSitu(field, bisected(field.size(), ranks, 5), look, {picture});
        EXPECT_THAT(drawn.failures, Each(""));
        ASSERT_EQ(drawn.images.size(), 1U);
        EXPECT_LE(largestDifference(drawn.images[0], alone), 1.0 / 255) << ranks;
      }
    }
}

TEST(InSitu, valuesAreThoseOfTheWholeVolume) {
  const Field field({60, 50, 40});
  const Volume whole = Volume::borrow(field.voxels.data(), field.layout());
  const std::vector<Box3> boxes = bisected(field.size(), 5, 3);
  const ValueHistogram expected = whole.histogram(64);
  std::vector<std::unique_ptr<Communicator>> ranks = inProcessRanks(5);
  std::vector<std::thread> threads;
  for (size_t rank = 0; rank < boxes.size(); ++rank)
    threads.emplace_back([&, rank] {
      const Part part(field, boxes[rank], 1, 2);
      const Volume volume = Volume::borrow(part.voxels.data(), field.layout(), part.box,
                                           ranksOf(std::move(ranks[rank])));
      EXPECT_EQ(volume.info().value_range, whole.info().value_range);
      EXPECT_EQ(volume.info().dims, whole.info().dims);
      EXPECT_EQ(volume.histogram(64).counts, expected.counts);
    });
  for (std::thread& thread : threads) thread.join();
}

// A rank holds what it draws, within its budget: here a quarter of what the volume takes.
TEST(InSitu, aRankHoldsNoMoreThanItsOwnBlocks) {
  const Field field({97, 70, 83});
  const LookOptions look{.threshold = 0, .opacity = 0.02, .light = LookOptions::Light::kOff};
  const Drawn one = drawInSitu(field, bisected(field.size(), 1, 5), look, {pictureFrom(30, true)});
  const Drawn seven =
      drawInSitu(field, bisected(field.size(), 7, 5), look, {pictureFrom(30, true)});
  EXPECT_LT(seven.most_peak_bytes, one.most_peak_bytes);
}

// The peak of a process that draws with so many ranks, beyond the arrays that they lend.
int64_t peakBeyondTheArrays(int ranks, uint64_t memory_bytes) {
  std::array<int, 2> said{};
  if (pipe(said.data()) != 0) fail("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    mallopt(M_MMAP_THRESHOLD, 128 << 10);  // freed memory is gone, as docs/library.md says
    const Field field({256, 240, 200});
    const LookOptions look{.threshold = 500, .opacity = 0.05};
    const std::vector<Box3> boxes = bisected(field.size(), ranks, 5);
    std::vector<Part> parts;
    for (const Box3& box : boxes) parts.emplace_back(field, box, 1, 2);
    const auto before = static_cast<int64_t>(peakResidentBytes());
    std::vector<std::unique_ptr<Communicator>> all = inProcessRanks(static_cast<int>(boxes.size()));
    std::vector<std::thread> threads;
    for (size_t rank = 0; rank < parts.size(); ++rank)
      threads.emplace_back([&, rank] {
        const Volume volume =
            Volume::borrow(parts[rank].voxels.data(), field.layout(), parts[rank].box,
                           ranksOf(std::move(all[rank])), {}, {.memory_bytes = memory_bytes});
        Renderer(volume, look, onCpu(memory_bytes)).draw(pictureFrom(30, true));
      });
    for (std::thread& thread : threads) thread.join();
    const int64_t beyond = static_cast<int64_t>(peakResidentBytes()) - before;
    _exit(write(said[1], &beyond, sizeof beyond) == sizeof beyond ? 0 : 1);
  }
  close(said[1]);
  int64_t beyond = -1;
  if (read(said[0], &beyond, sizeof beyond) != sizeof beyond) beyond = -1;
  close(said[0]);
  waitpid(child, nullptr, 0);
  return beyond;
}

// Whatever ranks there are in a process, each takes what it was given and a little for its program.
TEST(InSitu, aRankTakesNoMoreThanItsMemory) {
  constexpr int64_t kMemory = int64_t{24} << 20, kProgram = int64_t{12} << 20;
  for (const int ranks : {1, 2, 4, 7}) {
    const int64_t beyond = peakBeyondTheArrays(ranks, kMemory);
    EXPECT_GT(beyond, 0) << ranks;
    EXPECT_LE(beyond, ranks * kMemory + kProgram) << ranks;
    RecordProperty("beyond_" + std::to_string(ranks), std::to_string(beyond >> 20) + " MiB");
  }
}

}  // namespace
}  // namespace sluice
