// The library as others use it: installed, found by its package, seen through its headers alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/library/library_support.h"
#ifdef SLUICE_HAS_VDB
#include "tests/support/vdb_writer.h"
#endif

namespace sluice {
namespace {

using testing::HasSubstr;

constexpr const char* kWarnings = "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror";

class Installed : public testing::Test {
 protected:
  Installed() {
    run(SLUICE_CMAKE " --install " + shellQuoted(SLUICE_BUILD_DIR) + " --prefix " + prefix());
  }
  std::string prefix() const { return shellQuoted((folder_ / "prefix").string()); }
  // The command runs in the folder. Throws Error when it fails.
  std::string run(const std::string& line) const {
    const CommandResult result =
        runCommand("cd " + shellQuoted(folder_.path().string()) + " && " + line);
    if (result.status != 0) throw Error(line + "\n" + result.output);
    return result.output;
  }
  // Configured against the installed library alone, and built.
  void build(const std::string& source) const {
    run(SLUICE_CMAKE " -S " + shellQuoted(source) + " -B build -DCMAKE_BUILD_TYPE=Release" +
        " -DCMAKE_CXX_COMPILER=" + shellQuoted(SLUICE_CXX) +
        " -DCMAKE_CXX_FLAGS=" + shellQuoted(kWarnings) + " -DCMAKE_PREFIX_PATH=" + prefix());
    run(SLUICE_CMAKE " --build build");
  }

  const TempFolder folder_;
};

TEST_F(Installed, theTurntableDrawsWhatTheProgramDraws) {
  build(SLUICE_SOURCE_DIR "/examples");
  run(SLUICE_PROGRAM " synth shells -q -o shells_40x40x40_uint8.raw --dims 40,40,40");
  const std::string said = run("build/turntable shells_40x40x40_uint8.raw 90 out.png");
  EXPECT_THAT(said, HasSubstr("shells_40x40x40_uint8.raw on "));
  EXPECT_THAT(said, HasSubstr("90 degrees: 0 %\n"));
  EXPECT_THAT(said, HasSubstr("270 degrees: 100 %\n"));
  EXPECT_THAT(said, HasSubstr("one picture: cancelled\n"));
  const Rgba8Picture drawn = readPng(folder_ / "out.png");
  const Rgba8Picture expected = programPicture(folder_, "shells_40x40x40_uint8.raw --threshold 90");
  EXPECT_EQ(drawn.width, expected.width);
  EXPECT_LE(largestDifference(drawn.rgba, expected.rgba), 1);
  EXPECT_GT(visiblePixels(drawn.rgba), 10000U);

#ifdef SLUICE_HAS_VDB
  // Read by the module in the folder where the library was installed, and nowhere else.
  writePoints(folder_ / "points.vdb", {{{1, 2, 3}, 4.0F}, {{9, 9, 9}, 3.0F}});
  run("build/turntable points.vdb 0.5 points.png");
  EXPECT_GT(visiblePixels(readPng(folder_ / "points.png").rgba), 100U);
  std::filesystem::remove(folder_ / "prefix" / "lib" / "sluice" / "sluice_openvdb.so");
  EXPECT_THAT(runCommand("cd " + shellQuoted(folder_.path().string()) +
                         " && build/turntable points.vdb 0.5 points.png")
                  .output,
              HasSubstr((folder_ / "prefix" / "lib" / "sluice").string()));
#endif

  const CommandResult failed = runCommand("cd " + shellQuoted(folder_.path().string()) +
                                          " && build/turntable none_8x8x8_uint8.raw 90 no.png");
  EXPECT_EQ(failed.status, 1);
  EXPECT_THAT(failed.output, HasSubstr("turntable: none_8x8x8_uint8.raw"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "no.png"));
}

TEST_F(Installed, examplesDoTheirJobs) {
  build(SLUICE_SOURCE_DIR "/examples");
  EXPECT_THAT(run("build/array drops.png"), HasSubstr("values from "));
  EXPECT_GT(visiblePixels(readPng(folder_ / "drops.png").rgba), 5000U);
  run("build/custom_source gyroid.png");
  EXPECT_GT(visiblePixels(readPng(folder_ / "gyroid.png").rgba), 100000U);
  const std::string said =
      run("build/cache_study synth:shells,dims=96x96x96 90 turn.trace && " SLUICE_PROGRAM
          " simulate turn.trace --policies lru");
  EXPECT_THAT(said, HasSubstr("1024 MiB"));
  EXPECT_THAT(said, HasSubstr("lru"));
  EXPECT_EQ(runCommand("cd " + shellQuoted(folder_.path().string()) + " && build/array").status, 2);
}

TEST_F(Installed, headersStandAloneAndShowNothingElse) {
  const std::filesystem::path headers = folder_ / "prefix" / "include" / "sluice";
  int compiled = 0;
  for (const auto& entry : std::filesystem::directory_iterator(headers)) {
    writeFile(folder_ / "alone.cpp",
              "#include <sluice/" + entry.path().filename().string() + ">\n");
    run(shellQuoted(SLUICE_CXX) + " -std=c++20 -fsyntax-only " + kWarnings + " -I " + prefix() +
        "/include alone.cpp");
    ++compiled;
  }
  EXPECT_GE(compiled, 6);
}

}  // namespace
}  // namespace sluice
