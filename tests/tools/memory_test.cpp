// Compares the process's own memory with --memory: min-max arrays, textures and all.
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <string>

#include "tests/tools/program.h"

namespace sluice {
namespace {

// 1 GiB with a voxel that is not background in each block of 16^3, and noise in a corner; most of
// it are holes of the file.
void writeSparseSlab(const std::filesystem::path& path) {
  constexpr int64_t kSide = 1024, kNoise = 320, kCells = 15;
  std::ofstream file(path, std::ios::binary);
  std::string row(kSide, '\0');
  for (size_t x = 0; x < row.size(); x += kCells) row[x] = 1;
  const auto writeAt = [&](int64_t y, int64_t z, const std::string& bytes) {
    file.seekp((z * kSide + y) * kSide);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  };
  for (int64_t z = 0; z < kSide; z += kCells)
    for (int64_t y = 0; y < kSide; y += kCells) writeAt(y, z, row);
  std::mt19937 random(1);
  std::string noise(kNoise, '\0');
  for (int64_t z = 0; z < kNoise; ++z)
    for (int64_t y = 0; y < kNoise; ++y) {
      for (char& c : noise) c = static_cast<char>(random());
      writeAt(y, z, noise);
    }
  file.close();
  std::filesystem::resize_file(path, kSide * kSide * kSide);
}

// The process may take this much of its own over --memory: the program itself.
constexpr int64_t kProgram = 12 << 20;

bool takesMemoryOfItsOwn() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return false;
#else
  return true;
#endif
}

int64_t ownBytes(const nlohmann::json& report) {
  return report["peak_anonymous_bytes"].get<int64_t>();
}

TEST(Memory, whatTheProcessTakesOfItsOwnIsWithin64MiBOfTheBudget) {
  if (!takesMemoryOfItsOwn()) GTEST_SKIP() << "a sanitizer's own memory";
  constexpr int64_t kMemory = 128 << 20, kBeside = 64 << 20;
  const Program program;
  writeSparseSlab(program.folder / "slab_1024x1024x1024_uint8.raw");
  const auto report = program.json(
      "render slab_1024x1024x1024_uint8.raw -o a.png --size 128x128 --memory 128M --block 16 "
      "--threshold 2 --crop 0,0,0,319,319,319 --step 2");
  const auto own = report["peak_anonymous_bytes"].get<int64_t>();
  const auto ranges = report["volume"]["index"]["bytes"].get<int64_t>();
  EXPECT_GT(ranges, 30 << 20);  // the budget must have room for these too
  EXPECT_LE(own, kMemory + kBeside);
  EXPECT_LE(own, report["peak_rss_bytes"].get<int64_t>());
  // The process really took that much: the levels are full, so they alone need it.
  int64_t levels = ranges;
  for (const char* level : {"volume_buffer", "texture_buffer"})
    levels += report["levels"][level]["current_bytes"].get<int64_t>();
  EXPECT_GT(levels, kMemory / 2);
  EXPECT_GE(own, levels);
}

// Tiles keep what blocks add along their rays: here 30 MiB if nothing bounds them.
TEST(Memory, whatCullingKeepsIsOfTheBudget) {
  if (!takesMemoryOfItsOwn()) GTEST_SKIP() << "a sanitizer's own memory";
  constexpr int64_t kMemory = 48 << 20;
  const Program program;
  const auto report = program.json(
      "render synth:mixing,dims=96x96x96,steps=3 --time 0:2 --culling toc --block 8 --memory 48M "
      "--size 700x700 --device cpu -o mix_%d.png");
  EXPECT_GT(report["frames"][2]["culling"]["visible"].get<int64_t>(), 0);
  EXPECT_LE(ownBytes(report), kMemory + kProgram);
  // An eighth of the budget and the picture are accounted for.
  EXPECT_GT(report["beside_memory_bytes"].get<int64_t>(),
            kMemory / 8 + report["picture_memory_bytes"].get<int64_t>());
}

// The plan of 20 000 blocks takes as much as a third of the budget.
TEST(Memory, thePlanOfManyBlocksIsOfTheBudget) {
  if (!takesMemoryOfItsOwn()) GTEST_SKIP() << "a sanitizer's own memory";
  constexpr int64_t kMemory = 48 << 20;
  const Program program;
  const std::string what =
      "synth:phantom,dims=200x200x200 --block 8 --memory 48M --size 200x200 --device cpu "
      "--threshold 20";
  const auto plan = program.json("plan " + what);
  const auto report = program.json("render " + what + " -o a.png");
  EXPECT_GT(report["blocks"]["grey"].get<int64_t>() + report["blocks"]["black"].get<int64_t>(),
            20'000);
  EXPECT_LE(ownBytes(report), kMemory + kProgram);
  EXPECT_LE(ownBytes(report), plan["memory"]["peak_bytes"].get<int64_t>());
}

// A block of 128^3 floats takes 8 MiB, this volume 1 MiB.
TEST(Memory, aBlockTakesNoMoreThanTheVolume) {
  const Program program;
  const std::string what = "synth:phantom,dims=64x64x64,type=f32 --size 64x64 --device cpu ";
  const auto least = [&](const std::string& block) {
    // The least has fewer pages for smaller blocks, and the buffers are what is compared.
    const auto plan = program.json("plan " + what + "--memory 64M --pages 64 --block " + block);
    return plan["memory"]["least_bytes"].get<double>();
  };
  // Two chunks, and two threads with a block and a chunk each: none is larger than the volume but
  // for its border and whole pages. A whole block of 128 would be eight times the volume.
  constexpr double kVolumeBytes = 64 * 64 * 64 * 4;
  EXPECT_LT(least("128"), least("64") + 8 * kVolumeBytes);
  const auto report =
      program.json("render " + what + "--memory 64M --block 128 --verify -o large.png");
  EXPECT_LE(report["verify"]["max_difference"].get<double>(), 1);
}

}  // namespace
}  // namespace sluice
