#include "io/sequence.h"

#include <gmock/gmock.h>

#include <thread>

#include "io/open_volume.h"
#include "tests/io/image_test_support.h"
#include "tests/support/memory_source.h"

namespace sluice::sequence_test {
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
    return [this](const std::string& path,
                  const std::optional<ChannelWish>& /*channel*/) -> std::unique_ptr<VolumeSource> {
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

// An image of VTK of 2 x 2 x 2 points, whose arrays have these names and are full of these numbers.
std::string imageOf(const std::vector<std::pair<std::string, int>>& arrays) {
  std::string text =
      R"(<VTKFile type="ImageData"><ImageData WholeExtent="0 1 0 1 0 1"><Piece Extent="0 1 0 1 0 1">)"
      "<PointData>";
  for (const auto& [name, number] : arrays) {
    text += fmt::format(R"(<DataArray type="UInt8" Name="{}" format="ascii">)", name);
    for (int i = 0; i < 8; ++i) text += fmt::format("{} ", number);
    text += "</DataArray>";
  }
  return text + "</PointData></Piece></ImageData></VTKFile>";
}

TEST(Sequence, aChannelIsThatOfItsNameInEachStep) {
  const TempFolder folder;
  writeFile(folder / "s_0.vti", imageOf({{"p", 10}, {"q", 20}}));
  writeFile(folder / "s_1.vti", imageOf({{"q", 21}, {"r", 31}, {"p", 11}}));
  writeFile(folder / "s_2.vti", imageOf({{"q", 22}, {"r", 32}}));
  writeFile(folder / "s_3.vti", imageOf({{"p", 13}, {"p", 23}}));
  const std::string series = (folder / "s_%d.vti").string();
  const auto valueOf = [&](const ChannelWish& channel, int64_t time) {
    return static_cast<int>(readAll(*openVolume(series, {.channel = channel}), time).front());
  };
  for (const ChannelWish& p : {ChannelWish(), ChannelWish(0), ChannelWish(std::nullopt, "p")}) {
    EXPECT_EQ(valueOf(p, 0), 10);
    EXPECT_EQ(valueOf(p, 1), 11);
    EXPECT_THAT(errorOf([&] { valueOf(p, 2); }),
                AllOf(HasSubstr("s_2.vti: expected a channel called p as in the first time step"),
                      HasSubstr("0 (q), 1 (r)")));
    EXPECT_THAT(errorOf([&] { valueOf(p, 3); }), HasSubstr("must have it once"));
  }
  for (const ChannelWish& q : {ChannelWish(1), ChannelWish(std::nullopt, "q")})
    for (const int64_t time : {0, 1, 2}) EXPECT_EQ(valueOf(q, time), 20 + time);
  // An index tells the channels apart by their numbers in the first step.
  EXPECT_EQ(openVolume(series, {.channel = 1})->layout().channel, 1);
  EXPECT_EQ(openVolume(series, {.channel = ChannelWish(std::nullopt, "q")})->layout().channel, 1);
}

TEST(Sequence, channelsWithoutNamesOfTheirOwnGoByTheirNumbers) {
  const TempFolder folder;
  writeFile(folder / "s_0.vti", imageOf({{"p", 10}, {"p", 20}}));
  writeFile(folder / "s_1.vti", imageOf({{"q", 11}, {"p", 21}}));
  writeFile(folder / "t_0.vti", imageOf({{"density 0", 30}}));
  writeFile(folder / "t_1.vti", imageOf({{"density 1", 31}}));
  writeFile(folder / "t_2.vti", imageOf({{"speed", 42}, {"density 0", 32}}));
  writeFile(folder / "t_3.vti", imageOf({{"speed", 43}, {"density 3", 33}}));
  const auto valueOf = [&](const char* series, const ChannelWish& channel, int64_t time = 1) {
    const auto source = openVolume((folder / series).string(), {.channel = channel});
    return static_cast<int>(readAll(*source, time).front());
  };
  EXPECT_EQ(valueOf("s_%d.vti", 0), 11);
  EXPECT_EQ(valueOf("s_%d.vti", 1), 21);
  // The only channel of each file needs no name; among several it does.
  for (const ChannelWish& only : {ChannelWish(), ChannelWish(0)}) {
    EXPECT_EQ(valueOf("t_%d.vti", only), 31);
    EXPECT_EQ(valueOf("t_%d.vti", only, 2), 32);
    EXPECT_THAT(errorOf([&] { valueOf("t_%d.vti", only, 3); }),
                HasSubstr("expected a channel called density 0"));
  }
  const ChannelWish named(std::nullopt, "density 0");
  EXPECT_EQ(valueOf("t_%d.vti", named, 2), 32);
  EXPECT_THAT(errorOf([&] { valueOf("t_%d.vti", named); }), HasSubstr("--channel density 0"));
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

TEST(Sequence, stepsMayBeNoFiles) {
  const auto source =
      openVolume(std::vector<std::string>{"synth:cube,dims=4x4x4", "synth:shells,dims=4x4x4"});
  EXPECT_EQ(source->layout().time_steps, 2);
  EXPECT_NE(source->identity(),
            openVolume(std::vector<std::string>{"synth:cube,dims=4x4x4", "synth:cube,dims=4x4x4"})
                ->identity());
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
}  // namespace sluice::sequence_test
