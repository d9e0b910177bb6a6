// Volumes whose chunks, tiles or slices are wider than blocks: how often they are decoded, against
// the plan and the number of chunks there are.
#include <gmock/gmock.h>

#include <fmt/format.h>

#include <string>
#include <vector>

#include "io/open_volume.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SharedChunks : public testing::Test {
 protected:
  // Writes the files: noise, so that each chunk takes about as many bytes as every other one.
  void SetUp() override {
    const CommandResult made = program_.inFolder(
        "/usr/bin/python3 -c \"import numpy, h5py, tifffile\nn = 192\n"
        "a = numpy.random.default_rng(1).integers(0, 200, (n, n, n), dtype='u1')\n"
        "h5py.File('slabs.h5', 'w').create_dataset('v', data=a, chunks=(8, n, n), "
        "compression='gzip', compression_opts=1)\n"
        "write = lambda name, **of: tifffile.imwrite(name, a, photometric='minisblack', "
        "metadata={'axes': 'ZYX'}, **of)\n"
        "write('tiles.tif', tile=(64, 64), compression='zlib')\n"
        "write('strips.tif', rowsperstrip=32, compression='zlib')\n"
        "write('plain.tif')\"");
    if (made.status != 0) GTEST_SKIP() << "Python has no numpy, h5py or tifffile";
  }
  static std::string options(const std::string& volume, const std::string& memory) {
    return fmt::format(" {} --threshold 20 --block 32 --device cpu --size 100 --memory {} ", volume,
                       memory);
  }
  nlohmann::json plan(const std::string& volume, const std::string& memory) const {
    return program_.json("plan" + options(volume, memory));
  }
  // The bytes that a picture reads of the file.
  double readBytes(const std::string& volume, const std::string& memory) const {
    const auto drawn = program_.json("render" + options(volume, memory) + "--force -o a.png");
    return drawn["levels"]["disk"]["read_bytes"].get<double>();
  }
  const Program program_;
};

// Blocks of 4 voxels own a cell or three a side: the memory is theirs, not the voxels'.
TEST(SmallBlocks, thatTakeFarMoreThanTheVoxelsAreWarnedOf) {
  const Program program;
  const auto said = [&](const std::string& block) {
    return program.run("plan synth:cube,dims=200x200x200 --no-shade --block " + block).output;
  };
  EXPECT_THAT(said("4"), HasSubstr("--block 4 makes 300763 blocks, which take up to "));
  EXPECT_THAT(said("16"), Not(HasSubstr("--block 16 makes")));
}

TEST_F(SharedChunks, areDecodedNoMoreOftenThanThePlanSays) {
  struct Case {
    const char* volume;
    int64_t chunks, pages = 0;
  };
  for (const Case& c :
       {Case{"slabs.h5", 24}, {"tiles.tif", 9 * 192, 192}, {"strips.tif", 6 * 192, 192}}) {
    readBytes(c.volume, "512M");  // makes the index
    const double all = readBytes(c.volume, "512M");
    // Each thread reads the tables of the pages that it decodes, and threads share them by chance.
    const double tables = 4 * 2048.0 * static_cast<double>(c.pages);
    for (const char* memory : {"512M", "32M", "16M", "12M"}) {
      SCOPED_TRACE(fmt::format("{} {}", c.volume, memory));
      const nlohmann::json store = plan(c.volume, memory)["store"];
      EXPECT_EQ(store["chunks"], c.chunks);
      EXPECT_GE(store["decoded_bytes"], 192 * 192 * 192);
      const double told = store["most_decodes"].get<double>();
      EXPECT_LE(readBytes(c.volume, memory),
                1.02 * all * told / static_cast<double>(c.chunks) + tables);
      const std::string said = program_.run("plan" + options(c.volume, memory)).output;
      if (memory == std::string("512M")) {
        EXPECT_EQ(told, static_cast<double>(c.chunks));
      }
      EXPECT_THAT(said, HasSubstr(fmt::format(
                            "decodes {} chunks{}", c.chunks,
                            told > static_cast<double>(c.chunks) ? " up to " : ", each once")));
    }
  }
  // Rows that are not compressed are read where they lie.
  EXPECT_FALSE(plan("plain.tif", "16M").contains("store"));
  EXPECT_THAT(program_.run("plan" + options("plain.tif", "16M")).output, Not(HasSubstr("decodes")));
}

// The first refusal names a budget that draws, so that nobody has to try twice.
TEST_F(SharedChunks, areRefusedWithABudgetThatDraws) {
  for (const char* volume : {"slabs.h5", "tiles.tif", "slabs.h5 --block 8"}) {
    SCOPED_TRACE(volume);
    const std::string line =
        fmt::format("render {} --threshold 20 --size 300 --force -o a.png ", volume);
    const CommandResult refused = program_.run(line + "--memory 700K");
    EXPECT_EQ(refused.status, 1);
    ASSERT_THAT(refused.output,
                AllOf(HasSubstr(" or more to look at it, and "), HasSubstr(" to draw it")));
    const size_t at = refused.output.find("look at it, and ") + 16;
    const std::string budget = refused.output.substr(at, refused.output.find(' ', at) - at);
    EXPECT_LT(std::stoi(budget), 200);
    const CommandResult drawn = program_.run(line + "--memory " + budget);
    EXPECT_EQ(drawn.status, 0) << budget << ": " << drawn.output;
  }
}

// One by one, each box would decode the slabs or pages that it lies in.
TEST_F(SharedChunks, areDecodedOnceForAllBoxesThatAreReadTogether) {
  const CommandResult made = program_.inFolder(
      "/usr/bin/python3 -c \"import tifffile, zarr\na = tifffile.imread('plain.tif')\n"
      "zarr.open('slabs', mode='w', shape=a.shape, chunks=(8, 192, 192), dtype='u1')[:] = a\"");
  if (made.status != 0) GTEST_SKIP() << "Python has no zarr";
  for (const char* volume : {"slabs", "tiles.tif", "strips.tif"}) {
    SCOPED_TRACE(volume);
    const auto source = openVolume((program_.folder / volume).string());
    source->holdAtMost(1);
    const auto bytesOf = [&](const Box3& box) {
      return std::vector<std::byte>(static_cast<size_t>(box.count()));
    };
    const auto readSince = [&](uint64_t before) {
      return static_cast<double>(source->storedBytesRead() - before);
    };
    // Boxes of a layer, with planes in common, and one of another layer.
    std::vector<Box3> boxes{{{0, 0, 100}, {192, 192, 110}}};
    for (int64_t y = 0; y < 160; y += 40)
      for (int64_t x = 0; x < 160; x += 40) boxes.push_back({{x, y, 10}, {x + 41, y + 41, 50}});
    std::vector<std::vector<std::byte>> alone, together;
    std::vector<RegionRead> regions;
    double one_by_one = 0;
    for (const Box3& box : boxes) {
      const uint64_t before = source->storedBytesRead();
      source->readRegion(0, box, alone.emplace_back(bytesOf(box)));
      one_by_one += readSince(before);
      together.push_back(bytesOf(box));
    }
    for (size_t i = 0; i < boxes.size(); ++i) regions.push_back({boxes[i], together[i]});
    const uint64_t before = source->storedBytesRead();
    source->readRegions(0, regions);
    EXPECT_LT(readSince(before), 0.15 * one_by_one);
    EXPECT_TRUE(together == alone);
  }
}

}  // namespace
}  // namespace sluice
