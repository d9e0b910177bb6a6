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

TEST(Memory, whatTheProcessTakesOfItsOwnIsWithin64MiBOfTheBudget) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer's own memory";
#endif
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

}  // namespace
}  // namespace sluice
