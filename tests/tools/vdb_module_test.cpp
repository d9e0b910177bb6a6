// OpenVDB is a module beside the program: opened with the first .vdb, missed in one line.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/vdb_writer.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModule = "sluice_openvdb.so";

// A program in a folder of its own, so that what lies beside it is the test's choice.
struct MovedProgram {
  MovedProgram() {
    fs::create_directories(place());
    fs::copy_file(SLUICE_PROGRAM, place() / "sluice");
    writePoints(folder / "points.vdb", {{{1, 2, 3}, 4.0F}});
  }
  fs::path place() const { return folder / "bin"; }
  CommandResult run(const std::string& arguments) const {
    return runCommand("cd " + shellQuoted(folder.path().string()) +
                      " && XDG_CACHE_HOME=\"$PWD/cache\" bin/sluice " + arguments);
  }
  TempFolder folder;
};

fs::path builtModule() {
  return fs::path(SLUICE_PROGRAM).parent_path() / kModule;
}

TEST(VdbModule, missingModuleIsOneLineThatNamesIt) {
  const MovedProgram program;
  const CommandResult result = program.run("info points.vdb");
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  EXPECT_NE(result.output.find("points.vdb: an OpenVDB file"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find(kModule), std::string::npos) << result.output;
}

TEST(VdbModule, otherVolumesNeedNoModule) {
  const MovedProgram program;
  EXPECT_EQ(program.run(std::string("info ") + kSmall).status, 0);
}

TEST(VdbModule, isFoundWhereTheProgramWasBuilt) {
  const Program program;
  writePoints(program.folder / "points.vdb", {{{1, 2, 3}, 4.0F}});
  const CommandResult result = program.run("info points.vdb");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_NE(result.output.find("3 x 3 x 3 voxels"), std::string::npos) << result.output;
}

// What lies beside a program that was moved, above it, or in the current folder may be anybody's.
TEST(VdbModule, isOpenedFromNoPlaceThatDependsOnWhereTheProgramIs) {
  for (const char* place : {"bin", "lib/sluice", "lib", "."}) {
    const MovedProgram program;
    fs::create_directories(program.folder / place);
    fs::copy_file(builtModule(), program.folder / place / kModule);
    const CommandResult result = program.run("info points.vdb");
    EXPECT_EQ(result.status, 1) << place << ": " << result.output;
    EXPECT_NE(result.output.find("/lib/sluice/sluice_openvdb.so"), std::string::npos)
        << result.output;
  }
}

// What the module throws is an Error to the program, which prints its line.
TEST(VdbModule, itsErrorsArriveAsLines) {
  const Program program;
  writeFrustum(program.folder / "frustum.vdb");
  const CommandResult result = program.run("info frustum.vdb");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.output.find("expected an affine one"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace sluice
