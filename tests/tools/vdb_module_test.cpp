// OpenVDB is a module beside the program or in lib/sluice of its prefix: opened with the first
// .vdb; its absence is reported in one line.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/vdb_writer.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModule = "sluice_openvdb.so";

// A program in a folder of its own, so that the test chooses the files next to it.
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

TEST(AnnotateModule, missingModuleIsOneLineThatNamesIt) {
  const MovedProgram program;
  const CommandResult result =
      program.run(std::string("render -q ") + kSmall + " -o p.png -s 128 --annotate");
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  EXPECT_NE(result.output.find("sluice_annotate.so"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("libcairo2"), std::string::npos) << result.output;
  EXPECT_FALSE(fs::exists(program.folder / "p.png"));
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

constexpr const char* kRefusal = "users who cannot replace";

void setOthersMayWrite(const fs::path& path, bool may) {
  fs::permissions(path, fs::perms::others_write,
                  may ? fs::perm_options::add : fs::perm_options::remove);
}
void setGroupMayWrite(const fs::path& path, bool may) {
  fs::permissions(path, fs::perms::group_write,
                  may ? fs::perm_options::add : fs::perm_options::remove);
}

// The module is opened, but not if others can write to one of `all`, which lead to it or hold the
// program, or if it belongs to somebody else.
void expectOnlyTrustedFilesAreOpened(const MovedProgram& program, const fs::path& module,
                                     std::vector<fs::path> all) {
  all.insert(all.end(), {program.place(), program.place() / "sluice", module});
  for (const fs::path& path : all) {
    setOthersMayWrite(path, false);
    setGroupMayWrite(path, false);
  }
  const CommandResult found = program.run("info points.vdb");
  EXPECT_EQ(found.status, 0) << found.output;
  for (const fs::path& path : all) {
    setOthersMayWrite(path, true);
    const CommandResult refused = program.run("info points.vdb");
    EXPECT_EQ(refused.status, 1) << path;
    EXPECT_NE(refused.output.find(module.string() + ": " + kRefusal), std::string::npos)
        << refused.output;
    EXPECT_EQ(std::count(refused.output.begin(), refused.output.end(), '\n'), 1);
    setOthersMayWrite(path, false);
  }
  // A group may write the module if it may write the program.
  setGroupMayWrite(module, true);
  EXPECT_EQ(program.run("info points.vdb").status, 1);
  setGroupMayWrite(program.place() / "sluice", true);
  EXPECT_EQ(program.run("info points.vdb").status, 0);
  if (geteuid() != 0) return;
  ASSERT_EQ(chown(module.c_str(), 0, 12345), 0) << "another group's";
  EXPECT_EQ(program.run("info points.vdb").status, 1);
  fs::permissions(module, fs::perms::owner_all);
  EXPECT_EQ(program.run("info points.vdb").status, 0);
  ASSERT_EQ(chown(module.c_str(), 12345, 12345), 0) << "somebody else's";
  EXPECT_EQ(program.run("info points.vdb").status, 1);
}

TEST(VdbModule, isFoundInLibSluiceOfTheProgramsPrefix) {
  const MovedProgram program;
  const fs::path lib = program.folder / "lib";
  fs::create_directories(lib / "sluice");
  fs::copy_file(builtModule(), lib / "sluice" / kModule);
  expectOnlyTrustedFilesAreOpened(program, lib / "sluice" / kModule, {lib, lib / "sluice"});
}

TEST(VdbModule, isFoundBesideAMovedProgram) {
  const MovedProgram program;
  const fs::path module = program.place() / kModule;
  fs::copy_file(builtModule(), module);
  // The kernel names the program's file, whatever it was called by.
  fs::create_symlink(program.place() / "sluice", program.folder / "link");
  EXPECT_EQ(runCommand("cd " + shellQuoted(program.folder.path().string()) +
                       " && XDG_CACHE_HOME=\"$PWD/cache\" ./link info points.vdb")
                .status,
            0);
  expectOnlyTrustedFilesAreOpened(program, module, {});
}

// Files above a program that was moved, or in the current folder, may be anybody's.
TEST(VdbModule, isOpenedFromNoPlaceAroundAMovedProgram) {
  for (const char* place : {"sluice", "lib", "."}) {
    const MovedProgram program;
    fs::create_directories(program.folder / place);
    fs::copy_file(builtModule(), program.folder / place / kModule);
    const CommandResult result = program.run("info points.vdb");
    EXPECT_EQ(result.status, 1) << place << ": " << result.output;
    EXPECT_NE(result.output.find("/lib/sluice/sluice_openvdb.so"), std::string::npos)
        << result.output;
  }
}

// An exception from the module is an Error to the program, which prints its line.
TEST(VdbModule, itsErrorsArriveAsLines) {
  const Program program;
  writeFrustum(program.folder / "frustum.vdb");
  const CommandResult result = program.run("info frustum.vdb");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.output.find("expected an affine one"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace sluice
