// Volumes that Python writes with other programs' writers, each with the voxels that must be read
// from it, and the common code of their tests.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/io/image_test_support.h"
#include "tests/support/made_once.h"

namespace sluice {

inline std::string asText(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
// All time steps, read one by one.
inline std::string allSteps(VolumeSource& source) {
  std::string bytes;
  for (int64_t t = 0; t < source.layout().time_steps; ++t) bytes += asText(readAll(source, t));
  return bytes;
}

// The volumes of one script, made once for all tests (made_once.h), which only read them. `Case`
// says which: its kScript (a file of this folder) writes into a folder, needs the Python modules of
// kModules, and leaves a line in cases.txt for each volume, which operator>> reads into a Case with
// a name. A suite is skipped by name if a module is missing.
template <class Case>
class PythonVolumesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    cases_.clear();
    const std::filesystem::path scripts = SLUICE_TEST_DIR;
    // Scripts share their patterns.
    const std::string text =
        readFile(scripts / Case::kScript) + readFile(scripts / "voxel_pattern.py");
    const std::string name =
        fmt::format("{}-{:016x}", Case::kScript, std::hash<std::string>()(text));
    folder_ = madeOnce(name, [&](const std::filesystem::path& folder) {
      if (!hasPythonModules(Case::kModules)) return false;
      const auto made =
          runCommand("/usr/bin/python3 " + shellQuoted((scripts / Case::kScript).string()) + " " +
                     shellQuoted(folder.string()));
      EXPECT_EQ(made.status, 0) << made.output;
      return made.status == 0;
    });
    if (folder_.empty()) return;
    std::istringstream lines(readFile(folder_ / "cases.txt"));
    Case c;
    while (lines >> c) cases_.push_back(c);
  }
  void SetUp() override {
    if (folder_.empty()) GTEST_SKIP() << "python3 with " << Case::kModules << " is missing";
  }
  static std::filesystem::path pathOf(const std::string& name) { return folder_ / name; }
  // x fastest, time step after time step, in this machine's byte order.
  static std::string voxelsOf(const std::string& name) { return readFile(pathOf(name + ".bin")); }

  static inline std::filesystem::path folder_;  // empty: not made
  static inline std::vector<Case> cases_;
};

// Boxes at random against the parts of `whole`, the voxels of all time steps, that they are.
inline void expectBoxesAreParts(VolumeSource& source, const std::string& whole) {
  const Vec3i dims = source.layout().dims;
  const size_t voxel = bytesPerVoxel(source.layout().type);
  std::mt19937 random(11);
  const auto below = [&](int64_t n) {
    return static_cast<int64_t>(random() % static_cast<uint64_t>(n));
  };
  for (int i = 0; i < 12; ++i) {
    Box3 box;
    for (int a = 0; a < 3; ++a) {
      box.lo[a] = below(dims[a]);
      box.hi[a] = box.lo[a] + 1 + below(dims[a] - box.lo[a]);
    }
    const int64_t step = below(source.layout().time_steps);
    std::string expected;
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y)
        expected += whole.substr(
            static_cast<size_t>(((step * dims.z + z) * dims.y + y) * dims.x + box.lo.x) * voxel,
            static_cast<size_t>(box.size().x) * voxel);
    ASSERT_TRUE(asText(readBox(source, box, step)) == expected);
  }
}

}  // namespace sluice
