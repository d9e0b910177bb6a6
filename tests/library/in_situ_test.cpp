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
#include "src/library/in_situ.h"
#include "src/parallel/communication/in_process.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;

// A volume in one array, of shells with a texture, so that any step between boxes would be seen.
struct Field {
  std::array<int64_t, 3> dims;
  std::vector<uint16_t> voxels;

  explicit Field(std::array<int64_t, 3> size) : dims(size) {
    for (int64_t z = 0; z < dims[2]; ++z)
      for (int64_t y = 0; y < dims[1]; ++y)
        for (int64_t x = 0; x < dims[0]; ++x) {
          const double r = std::hypot(x - 0.5 * dims[0], y - 0.4 * dims[1], z - 0.5 * dims[2]);
          const double v =
              2000 + 1500 * std::sin(r / 3) + 400 * std::sin(0.9 * x) * std::cos(1.1 * y);
          voxels.push_back(static_cast<uint16_t>(v));
        }
  }
  ArrayLayout layout() const { return {.dims = dims, .type = "u16", .spacing = {1, 1.2, 0.8}}; }
  Vec3i size() const { return {dims[0], dims[1], dims[2]}; }
};

// A rank of a simulation has its box with ghosts, as far as the volume reaches.
struct Part {
  LentBox box;
  std::vector<uint16_t> voxels;

  Part(const Field& field, const Box3& own, int64_t below, int64_t above) {
    const Vec3i ghosts_below{below, below, below}, ghosts_above{above, above, above};
    const Box3 there =
        unite(own, intersect({own.lo - ghosts_below, own.hi + ghosts_above}, boxOf(field.size())));
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<size_t>(a);
      box.lo[i] = own.lo[a];
      box.hi[i] = own.hi[a];
      box.ghosts_below[i] = own.lo[a] - there.lo[a];
      box.ghosts_above[i] = there.hi[a] - own.hi[a];
    }
    if (!boxOf(field.size()).contains(own)) return;  // refused before a voxel is read
    for (int64_t z = there.lo.z; z < there.hi.z; ++z)
      for (int64_t y = there.lo.y; y < there.hi.y; ++y)
        for (int64_t x = there.lo.x; x < there.hi.x; ++x)
          voxels.push_back(
              field.voxels[static_cast<size_t>((z * field.dims[1] + y) * field.dims[0] + x)]);
  }
};

// Cuts the longest side of the largest box again and again, at odd places.
std::vector<Box3> bisected(Vec3i dims, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Box3> boxes{boxOf(dims)};
  while (static_cast<int>(boxes.size()) < count) {
    const auto largest =
        std::max_element(boxes.begin(), boxes.end(),
                         [](const Box3& a, const Box3& b) { return a.count() < b.count(); });
    Box3 below = *largest, above = *largest;
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (below.size()[a] > below.size()[axis]) axis = a;
    const int64_t side = below.size()[axis];
    const int64_t at = below.lo[axis] + side / 2 + static_cast<int64_t>(random() % 7) - 3;
    below.hi[axis] = above.lo[axis] = at;
    *largest = below;
    boxes.push_back(above);
  }
  std::shuffle(boxes.begin(), boxes.end(), random);  // no rank is near its neighbours
  return boxes;
}

PictureOptions pictureFrom(double azimuth, bool perspective) {
  PictureOptions picture;
  picture.width = 120;
  picture.height = 100;
  picture.view.fit = ViewOptions::Fit::kVolume;  // as ranks do
  picture.view.azimuth_deg = azimuth;
  picture.view.elevation_deg = 25;
  picture.view.projection =
      perspective ? ViewOptions::Projection::kPerspective : ViewOptions::Projection::kParallel;
  return picture;
}

struct Drawn {
  std::vector<Image> images;  // rank 0's
  std::vector<std::string> failures;
  uint64_t most_peak_bytes = 0;  // of levels 2 to 3, of any rank
};

RendererOptions onCpu(uint64_t memory_bytes = uint64_t{64} << 20) {
  RendererOptions options;
  options.device = RendererOptions::Device::kCpu;
  options.memory_bytes = memory_bytes;
  options.threads = 1;
  return options;
}

Drawn drawInSitu(const Field& field, const std::vector<Box3>& boxes, const LookOptions& look,
                 const std::vector<PictureOptions>& pictures, int64_t below = 1, int64_t above = 2,
                 const RendererOptions& machine = onCpu()) {
  Drawn drawn;
  std::vector<std::unique_ptr<Communicator>> ranks = inProcessRanks(static_cast<int>(boxes.size()));
  std::vector<std::thread> threads;
  drawn.failures.resize(boxes.size());
  Mutex mutex;
  for (size_t rank = 0; rank < boxes.size(); ++rank)
    threads.emplace_back([&, rank] {
      try {
        const Part part(field, boxes[rank], below, above);
        const Ranks all = ranksOf(std::move(ranks[rank]));
        EXPECT_EQ(all.rank(), static_cast<int>(rank));
        const Volume volume = Volume::borrow(part.voxels.data(), field.layout(), part.box, all, {},
                                             {.memory_bytes = uint64_t{64} << 20, .threads = 1});
        Renderer renderer(volume, look, machine);
        for (const PictureOptions& picture : pictures) {
          Image image = renderer.draw(picture);
          const RenderReport report = renderer.report();
          const MutexLock lock(mutex);
          drawn.most_peak_bytes =
              std::max(drawn.most_peak_bytes,
                       report.volume_buffer.peak_bytes + report.texture_buffer.peak_bytes);
          if (rank == 0)
            drawn.images.push_back(std::move(image));
          else
            EXPECT_TRUE(image.rgba.empty());
        }
      } catch (const std::exception& error) {
        drawn.failures[rank] = error.what();
      }
    });
  for (std::thread& thread : threads) thread.join();
  return drawn;
}

double largestDifference(const Image& a, const Image& b) {
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  double most = 0;
  for (size_t i = 0; i < std::min(a.rgba.size(), b.rgba.size()); ++i)
    most = std::max(most, std::abs(double{a.rgba[i]} - double{b.rgba[i]}));
  return most;
}

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

TEST(InSitu, wholeBlocksAreRefused) {
  const Field field({40, 40, 40});
  const std::vector<Box3> boxes = {{{0, 0, 0}, {20, 40, 40}}, {{20, 0, 0}, {40, 40, 40}}};
  RendererOptions machine = onCpu();
  machine.pipeline.algorithm = "conventional";
  EXPECT_THAT(drawInSitu(field, boxes, {}, {}, 1, 2, machine).failures,
              Each(HasSubstr("pipeline.algorithm conventional draws blocks whole")));
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
