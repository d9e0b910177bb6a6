// The test helpers themselves: a helper that is wrong makes every test that leans on it worthless.
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "src/base/error.h"
#include "tests/support/counting_source.h"
#include "tests/support/failing_source.h"
#include "tests/support/float_picture.h"
#include "tests/support/memory_source.h"
#include "tests/support/random_volume.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

std::span<std::byte> bytesOf(auto& array) {
  return std::as_writable_bytes(std::span(array));
}

TEST(MemorySource, copiesABoxOfATimeStep) {
  VolumeLayout layout;
  layout.dims = {3, 4, 5};
  layout.time_steps = 2;
  const auto source = makeMemorySource<uint16_t>(
      layout, [](auto x, auto y, auto z, auto t) { return x + 10 * y + 100 * z + 1000 * t; });
  EXPECT_EQ(source->layout().type, VoxelType::kU16);
  std::array<uint16_t, 4> out{};
  source->readRegion(1, {{1, 2, 4}, {3, 4, 5}}, bytesOf(out));
  EXPECT_EQ(out, (std::array<uint16_t, 4>{1421, 1422, 1431, 1432}));
  EXPECT_EQ(source->storedBytesRead(), 8U);
}

TEST(CountingSource, countsWhatItSees) {
  const auto source = makeMemorySource<uint16_t>({4, 4, 4}, [](auto...) { return 7; });
  CountingSource counting(*source);
  std::array<uint16_t, 8> out{};
  const Box3 box = {{1, 1, 1}, {3, 3, 3}};
  counting.readRegion(0, box, bytesOf(out));
  counting.readRegion(0, box, bytesOf(out));
  EXPECT_EQ(out[7], 7);
  const auto counts = counting.counts();
  EXPECT_EQ(counts.calls, 2);
  EXPECT_EQ(counts.voxels, 16);
  EXPECT_EQ(counts.bytes, 32);
  EXPECT_EQ(counts.max_at_once, 1);
  EXPECT_EQ(counting.timesRead(0, box), 2);
  EXPECT_EQ(counting.timesRead(0, {{0, 0, 0}, {1, 1, 1}}), 0);
  counting.reset();
  EXPECT_EQ(counting.counts().calls, 0);
  EXPECT_TRUE(counting.reads().empty());
}

TEST(FailingSource, failsAtTheChosenReads) {
  const auto source = makeMemorySource<uint8_t>({2, 2, 2}, [](auto...) { return 9; });
  CountingSource counting(*source);
  FailingSource failing(counting, FailingSource::Failure::kError, 1, 2);
  CountingSource outer(failing);
  std::array<uint8_t, 8> out{};
  const Box3 all = boxOf({2, 2, 2});
  outer.readRegion(0, all, bytesOf(out));
  EXPECT_THROW(outer.readRegion(0, all, bytesOf(out)), Error);
  EXPECT_THROW(outer.readRegion(0, all, bytesOf(out)), Error);
  outer.readRegion(0, all, bytesOf(out));
  EXPECT_EQ(counting.counts().calls, 2);
  EXPECT_EQ(outer.counts().calls, 2);
  EXPECT_EQ(outer.counts().failures, 2);
}

TEST(FailingSource, throwsWhatNobodyTranslated) {
  const auto source = makeMemorySource<uint8_t>({2, 2, 2}, [](auto...) { return 9; });
  FailingSource failing(*source, FailingSource::Failure::kException, 0, FailingSource::kForever);
  std::array<uint8_t, 8> out{};
  for (int i = 0; i < 3; ++i) {
    try {
      failing.readRegion(0, boxOf({2, 2, 2}), bytesOf(out));
      ADD_FAILURE() << "did not throw";
    } catch (const Error&) {
      ADD_FAILURE() << "threw an Error";
    } catch (const std::runtime_error&) {
    }
  }
}

TEST(FailingSource, stallsUntilReleased) {
  const auto source = makeMemorySource<uint8_t>({2, 2, 2}, [](auto...) { return 9; });
  FailingSource stalling(*source, FailingSource::Failure::kStall, 0);
  CountingSource outer(stalling);
  std::array<uint8_t, 8> out{};
  std::thread reader([&] { outer.readRegion(0, boxOf({2, 2, 2}), bytesOf(out)); });
  stalling.waitUntilStalled();
  EXPECT_EQ(outer.counts().calls, 0);
  stalling.release();
  reader.join();
  EXPECT_EQ(outer.counts().calls, 1);
  EXPECT_EQ(out[0], 9);
}

TEST(TempFolder, isGoneAtTheEnd) {
  std::filesystem::path path;
  {
    const TempFolder folder;
    path = folder.path();
    writeFile(folder / "a", std::string("x\0y", 3));
    EXPECT_EQ(readFile(folder / "a"), std::string("x\0y", 3));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(RunCommand, givesStatusAndBothOutputs) {
  const auto result = runCommand("echo out; echo err >&2; exit 3");
  EXPECT_EQ(result.status, 3);
  EXPECT_EQ(result.output, "out\nerr\n");
  EXPECT_EQ(runCommand("kill -9 $$").status, 128 + 9);
  EXPECT_EQ(runCommand("printf %s " + shellQuoted("it's $HOME")).output, "it's $HOME");
  EXPECT_TRUE(haveProgram("sh"));
  EXPECT_FALSE(haveProgram("no-such-program"));
}

TEST(RandomVolume, isSeededAndSparse) {
  BlobOptions options;
  options.time_steps = 2;
  const auto a = makeSparseBlobs(options), b = makeSparseBlobs(options);
  options.seed = 2;
  const auto c = makeSparseBlobs(options);
  EXPECT_TRUE(std::ranges::equal(a->bytes(), b->bytes()));
  EXPECT_FALSE(std::ranges::equal(a->bytes(), c->bytes()));
  const auto zeros = std::ranges::count(a->bytes(), std::byte{0});
  const auto share = static_cast<double>(zeros) / static_cast<double>(a->bytes().size());
  EXPECT_GT(share, 0.3);
  EXPECT_LT(share, 0.99);
  const size_t step = a->bytes().size() / 2;
  EXPECT_FALSE(std::ranges::equal(a->bytes().first(step), a->bytes().last(step)));
}

TEST(FloatPicture, differencesAreInLevels) {
  FloatPicture a{2, 1, {0, 0, 0, 0, 1, 1, 1, 1}, {0, 0}};
  FloatPicture b = a;
  EXPECT_EQ(compare(a, b).max_255, 0);
  b.rgba[5] = 1 - 2 / 255.0f;
  b.rgba[0] = -5;  // clamped
  const Difference difference = compare(a, b);
  EXPECT_NEAR(difference.max_255, 2, 1e-4);
  EXPECT_NEAR(difference.mean_255, 2.0 / 8, 1e-4);
  EXPECT_EQ(difference.pixels_over, 1);
  EXPECT_EQ(difference.worst_x, 1);
  EXPECT_EQ(compare(a, b, 3).pixels_over, 0);
  b.rgba[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(compare(a, b).max_255, 255);
}

}  // namespace
}  // namespace sluice
