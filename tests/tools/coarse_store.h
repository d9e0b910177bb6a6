// A store whose level 0 has no index, for tests of pictures that do not wait for one.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {

inline constexpr const char* kCoarseLook =
    "--threshold 60 --opacity 0.1 --range 0,255 --no-shade --block 32 --view plain --fit volume "
    "--azimuth 30 --size 64 --force";

// A packed store without the index that packing made, as if it came from another machine.
class CoarseFirst : public testing::Test {
 protected:
  CoarseFirst() {
    run("pack synth:shells,dims=160x150x140 -o v.zarr --chunk 16 --levels 3");
    removeIndex();
  }
  std::string run(const std::string& command) const {
    const CommandResult result = program_.run(command);
    EXPECT_EQ(result.status, 0) << result.output;
    return result.output;
  }
  nlohmann::json render(const std::string& more) const {
    return program_.json(std::string("render v.zarr -o x.png ") + kCoarseLook + " " + more);
  }
  Rgba8Picture picture() const { return readPng(program_.folder / "x.png"); }
  void removeIndex() const { std::filesystem::remove_all(program_.folder / "cache"); }
  // As levels that another program made: means without spreads.
  void removeSpreads() const {
    std::filesystem::remove_all(program_.folder / "v.zarr/spread");
    std::string attributes = readFile(program_.folder / "v.zarr/.zattrs");
    attributes.replace(attributes.find("spreads"), 7, "nothing");
    writeFile(program_.folder / "v.zarr/.zattrs", attributes);
  }
  // Chunks have checksums: reading one of these is an error.
  void spoilLevelZero() const {
    for (const auto& file :
         std::filesystem::recursive_directory_iterator(program_.folder / "v.zarr/0"))
      if (file.is_regular_file() && file.path().filename().string().front() != '.')
        writeFile(file.path(), "spoilt");
  }
  // Bytes of all files below these folders of the store, and of the files beside them.
  uint64_t bytesOf(const std::vector<std::string>& levels) const {
    uint64_t bytes = 0;
    for (const std::string& level : levels)
      for (const auto& file :
           std::filesystem::recursive_directory_iterator(program_.folder / "v.zarr" / level))
        if (file.is_regular_file()) bytes += file.file_size();
    for (const auto& file : std::filesystem::directory_iterator(program_.folder / "v.zarr"))
      if (file.is_regular_file()) bytes += file.file_size();
    return bytes;
  }

  const Program program_;
};

inline double meanDifference(const Rgba8Picture& a, const Rgba8Picture& b) {
  double sum = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i) sum += std::abs(a.rgba[i] - b.rgba[i]);
  return sum / static_cast<double>(a.rgba.size());
}

}  // namespace sluice
