// The example of pictures in situ, under each launcher that there is, on a volume that NumPy made.
#include "tests/parallel/ranks_program.h"

namespace sluice {
namespace {

using testing::HasSubstr;

struct InSituProgram : MpiLauncher {
  std::string example;  // the program's path; empty: it was built without this MPI
};

void PrintTo(const InSituProgram& program, std::ostream* to) {
  *to << program.name;
}

class InSituRanks : public testing::TestWithParam<InSituProgram> {
  const OwnSessions sessions_;
};

TEST_P(InSituRanks, drawThePictureOfOneProcess) {
  const InSituProgram& mpi = GetParam();
  if (mpi.example.empty() || !mpi.missing().empty()) GTEST_SKIP() << mpi.name << " is missing";
  const Program program;
  const std::string in_folder = "cd " + shellQuoted(program.folder.path().string()) + " && ";
  const CommandResult made =
      runCommand(in_folder +
                 "/usr/bin/python3 -c \"import numpy as n\n"
                 "z, y, x = n.mgrid[0:70, 0:60, 0:50]\n"
                 "v = 120 + 60 * n.sin(x / 5) * n.cos(y / 7) + 50 * n.sin(z / 9)\n"
                 "v.astype('u1').tofile('sim_50x60x70_uint8.raw')\"");
  if (made.status != 0) GTEST_SKIP() << "Python has no numpy";
  ASSERT_EQ(program
                .run("render sim_50x60x70_uint8.raw --threshold 150 --fit volume --device cpu -q "
                     "-o one.png")
                .status,
            0);
  for (const int ranks : {1, 2, 4, 7}) {
    SCOPED_TRACE(ranks);
    const std::string picture = fmt::format("of_{}.png", ranks);
    const CommandResult drawn = runCommand(in_folder + mpi.startProgram(mpi.example, ranks, 120) +
                                           " sim_50x60x70_uint8.raw 50 60 70 150 " + picture);
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    EXPECT_LE(pictureDifference(program.folder / "one.png", program.folder / picture), 1);
  }
  const CommandResult failed = runCommand(in_folder + mpi.startProgram(mpi.example, 2, 120) +
                                          " none.raw 50 60 70 150 no.png");
  EXPECT_NE(failed.status, 0);
}

INSTANTIATE_TEST_SUITE_P(Mpi, InSituRanks,
                         testing::Values(InSituProgram{kOpenMpiLauncher, IN_SITU_OPENMPI},
                                         InSituProgram{kMpichLauncher, IN_SITU_MPICH}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace sluice
