// The program started as several ranks, by whichever launcher there is.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {

// An MPI's launcher with the options that it needs here: more ranks than cores, and perhaps root.
struct MpiLauncher {
  std::string name, module, programs, options;

  // The first of the names in `programs` that is installed; empty: none.
  std::string program() const {
    std::istringstream names(programs);
    for (std::string one; names >> one;)
      if (haveProgram(one)) return one;
    return "";
  }
  // Why its tests cannot be run; empty: they can.
  std::string missing() const {
    if (program().empty()) return name + ": no launcher";
    if (!std::filesystem::exists(std::filesystem::path(SLUICE_PROGRAM).parent_path() / module))
      return name + ": built without " + module;
    return "";
  }
  // A line of sh that starts the program so often, for as long at the most.
  std::string start(int ranks, int most_seconds = 200) const {
    return startProgram(SLUICE_PROGRAM, ranks, most_seconds);
  }
  std::string startProgram(const std::string& path, int ranks, int most_seconds) const {
    // Open MPI asks every X server for GPUs otherwise, and ends with one that another test stops.
    return fmt::format("HWLOC_COMPONENTS=-gl timeout -k 5 {} {} {} -n {} {}", most_seconds,
                       program(), options, ranks, path);
  }
  // Starts one rank for each list of arguments.
  std::string startEach(const std::vector<std::string>& arguments) const {
    std::string line;
    for (const std::string& one : arguments)
      line += line.empty() ? start(1) + " " + one : " : -n 1 " SLUICE_PROGRAM " " + one;
    return line;
  }
};

inline void PrintTo(const MpiLauncher& launcher, std::ostream* to) {
  *to << launcher.name;
}

// Open MPI draws a ring of cores around each rank otherwise, and copies by a system call that
// containers refuse.
inline const MpiLauncher kOpenMpiLauncher{
    "OpenMpi", "sluice_openmpi.so", "mpirun.openmpi orterun",
    "--quiet --allow-run-as-root --oversubscribe --bind-to none "
    "--mca btl_vader_single_copy_mechanism none"};
inline const MpiLauncher kMpichLauncher{"Mpich", "sluice_mpich.so", "mpiexec.mpich mpiexec.hydra",
                                        ""};

// A folder for what Open MPI keeps while ranks run. All of a user's share one folder otherwise,
// which a launcher that ends removes while another one starts in it.
struct OwnSessions {
  OwnSessions() { setenv("OMPI_MCA_orte_tmpdir_base", folder.path().c_str(), 1); }
  const TempFolder folder;
};

// A test that runs with each MPI that is there.
class RanksTest : public testing::TestWithParam<MpiLauncher> {
 protected:
  const OwnSessions sessions_;
  void SetUp() override {
    if (const std::string missing = GetParam().missing(); !missing.empty())
      GTEST_SKIP() << "skipped: " << missing;
  }
};

// The largest difference of a channel; 256 if the pictures cannot be compared.
inline int pictureDifference(const std::filesystem::path& a, const std::filesystem::path& b) {
  if (!std::filesystem::exists(a) || !std::filesystem::exists(b)) return 256;
  const auto one = readPng(a), other = readPng(b);
  if (one.rgba.size() != other.rgba.size()) return 256;
  int most = 0;
  for (size_t i = 0; i < one.rgba.size(); ++i)
    most =
        std::max(most, std::abs(static_cast<int>(one.rgba[i]) - static_cast<int>(other.rgba[i])));
  return most;
}

// How often a text has another in it.
inline int occurrences(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace sluice
