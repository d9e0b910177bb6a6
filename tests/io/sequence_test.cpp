#include "io/sequence.h"

#include <gmock/gmock.h>

#include <thread>

#include "tests/io/image_test_support.h"
#include "tests/support/memory_source.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

VolumeLayout layoutOf(Vec3i dims, VoxelType type = VoxelType::kU8, Vec3d spacing = {1, 1, 1},
                      Vec3d origin = {0, 0, 0}, double value_scale = 1) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.type = type;
  layout.spacing = spacing;
  layout.origin = origin;
  layout.value_scale = value_scale;
  return layout;
}

// Time steps of 4 voxels which all hold the number in their file's text; counts those that are
// open.
struct Steps {
  struct Counted : MemorySource {
    Counted(VolumeLayout layout, std::vector<std::byte> voxels, Steps& steps)
        : MemorySource(std::move(layout), std::move(voxels)), steps_(steps) {
      ++steps_.open;
    }
    ~Counted() override { --steps_.open; }
    void expectRegion(int64_t time, const Box3& box) override {
      EXPECT_EQ(time, 0);
      steps_.told.push_back({layout().name, box});
    }
    Steps& steps_;
  };

  explicit Steps(int count) {
    for (int i = 0; i < count; ++i) {
      files.push_back((folder / fmt::format("{}.step", i)).string());
      writeFile(files.back(), std::to_string(i));
    }
  }
  SequenceSource::Opener opener() {
    return [this](const std::string& path) -> std::unique_ptr<VolumeSource> {
      ++openings;
      const std::string text = readFile(path);
      VolumeLayout layout = changed && path == files[2] ? *changed : layoutOf({2, 2, 1});
      layout.name = path;
      return std::make_unique<Counted>(
          layout, std::vector<std::byte>(4, static_cast<std::byte>(std::stoi(text))), *this);
    };
  }

  TempFolder folder;
  std::vector<std::string> files;
  std::optional<VolumeLayout> changed;  // layout of step 2
  std::atomic<int> openings{0}, open{0};
  std::vector<std::pair<std::string, Box3>> told;  // file, box
};

TEST(Sequence, tellsTheStepOfABoxThatIsReadLater) {
  Steps steps(3);
  SequenceSource source(steps.files, steps.opener());
  const Box3 box{{0, 1, 0}, {2, 2, 1}};
  source.expectRegion(1, box);
  EXPECT_EQ(steps.told, (std::vector<std::pair<std::string, Box3>>{{steps.files[1], box}}));
}

TEST(Sequence, givesTheFilesAsTimeSteps) {
  Steps steps(5);
  SequenceSource source(steps.files, steps.opener());
  EXPECT_EQ(source.layout().time_steps, 5);
  EXPECT_EQ(source.layout().dims, (Vec3i{2, 2, 1}));
  for (const int64_t time : {4, 0, 2, 1, 3})
    EXPECT_EQ(readAll(source, time), std::vector<std::byte>(4, std::byte(time)));
  EXPECT_EQ(source.storedBytesRead(), 20U);
}

TEST(Sequence, opensFilesWhenTheyAreReadAndKeepsFew) {
  Steps steps(6);
  SequenceSource source(steps.files, steps.opener(), 2);
  EXPECT_EQ(steps.openings, 1);
  for (int64_t time = 0; time < 6; ++time) {
    readAll(source, time);
    EXPECT_LE(steps.open, 2);
  }
  EXPECT_EQ(steps.openings, 6);
  readAll(source, 5);
  EXPECT_EQ(steps.openings, 6);
  readAll(source, 0);
  EXPECT_EQ(steps.openings, 7);
  EXPECT_EQ(source.storedBytesRead(), 32U);  // includes files closed since
}

TEST(Sequence, namesTheFileThatDiffers) {
  for (const auto& [layout, words] :
       {std::pair{layoutOf({4, 1, 1}), "4 x 1 x 1 of u8, expected 2 x 2 x 1 of u8"},
        std::pair{layoutOf({2, 2, 1}, VoxelType::kI8), "of i8"},
        std::pair{layoutOf({2, 2, 1}, VoxelType::kU8, {1, 1, 2}), "spacing, origin or axes differ"},
        std::pair{layoutOf({2, 2, 1}, VoxelType::kU8, {1, 1, 1}, {1, 0, 0}),
                  "spacing, origin or axes differ"},
        std::pair{layoutOf({2, 2, 1}, VoxelType::kU8, {1, 1, 1}, {0, 0, 0}, 2),
                  "scaled by 2 + 0, expected 1 + 0"}}) {
    Steps steps(4);
    steps.changed = layout;
    SequenceSource source(steps.files, steps.opener());
    readAll(source, 1);
    EXPECT_THAT(errorOf([&] { readAll(source, 2); }),
                AllOf(HasSubstr(steps.files[2]), HasSubstr(words)));
  }
}

TEST(Sequence, rejectsAMissingFileAtOnce) {
  Steps steps(3);
  std::filesystem::remove(steps.files[1]);
  EXPECT_THAT(errorOf([&] { SequenceSource(steps.files, steps.opener()); }),
              HasSubstr(steps.files[1]));
}

TEST(Sequence, identityCoversAllFiles) {
  Steps steps(3);
  const auto identity = [&] {
    // The memory sources under it number themselves; that part is left out here.
    const std::string text = SequenceSource(steps.files, steps.opener()).identity();
    return text.substr(0, text.find("|first"));
  };
  const std::string before = identity();
  EXPECT_EQ(identity(), before);
  writeFile(steps.files[2], "22");
  EXPECT_NE(identity(), before);
}

TEST(Sequence, threadsReadAtOnce) {
  Steps steps(12);
  SequenceSource source(steps.files, steps.opener(), 2);
  std::vector<std::thread> threads;
  std::atomic<int> wrong{0};
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 300; ++i) {
        const int64_t time = (i * 7 + t * 5) % 12;
        if (readAll(source, time) != std::vector<std::byte>(4, std::byte(time))) ++wrong;
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(source.storedBytesRead(), 4U * 300 * 4);
  EXPECT_LE(steps.open, 2);
}

}  // namespace
}  // namespace sluice
