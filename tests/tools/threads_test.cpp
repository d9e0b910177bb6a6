// The program if the system gives fewer threads than it asks for: it goes on with those.
#include <gtest/gtest.h>

#include <unistd.h>

#include <string>

#include "tests/tools/program.h"

namespace sluice {
namespace {

// An account that nobody has, since root's processes are not limited.
constexpr const char* kNobody = "setpriv --reuid=61234 --regid=61234 --clear-groups ";

// A picture in `name`, drawn under `limit`, a line of sh before the command.
CommandResult drawn(const Program& program, const std::string& limit, const std::string& name,
                    const std::string& as = "") {
  return runCommand("cd " + shellQuoted(program.folder.path().string()) + " && " + limit +
                    " XDG_CACHE_HOME=\"$PWD/cache\" " + as + SLUICE_PROGRAM + " render " + kSmall +
                    " -o " + name + " --size 48x48 --pages 16 --memory 64M --threads 1024");
}

std::string bytesOf(const Program& program, const std::string& name) {
  return runCommand("cat " + shellQuoted((program.folder / name).string())).output;
}

TEST(Threads, whereAddressesRunOutThePictureIsDrawnWithFewer) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer takes all addresses";
#endif
  const Program program;
  const CommandResult free = drawn(program, "", "free.png");
  ASSERT_EQ(free.status, 0) << free.output;
  const CommandResult limited = drawn(program, "ulimit -v 3000000;", "limited.png");
  ASSERT_EQ(limited.status, 0) << limited.output;
  EXPECT_NE(limited.output.find("of 1024 threads"), std::string::npos) << limited.output;
  EXPECT_EQ(bytesOf(program, "limited.png"), bytesOf(program, "free.png"));
  EXPECT_EQ(free.output.find("of 1024 threads"), std::string::npos) << free.output;
}

// However little there is: a picture or one line, never a crash.
TEST(Threads, howeverFewAddressesThereAreItIsAPictureOrOneLine) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer takes all addresses";
#endif
  const Program program;
  for (const int kilobytes : {200'000, 400'000, 700'000, 1'000'000, 1'500'000}) {
    const CommandResult result =
        drawn(program, "ulimit -v " + std::to_string(kilobytes) + ";", "a.png");
    EXPECT_TRUE(result.status == 0 || result.status == 1)
        << kilobytes << ": " << result.status << result.output;
    EXPECT_TRUE(result.status == 0 || result.output.find("sluice: ") != std::string::npos)
        << result.output;
  }
}

TEST(Threads, whereProcessesAreCountedThePictureIsDrawnWithFewer) {
  if (geteuid() != 0 || !haveProgram("setpriv") || !haveProgram("prlimit"))
    GTEST_SKIP() << "root with setpriv and prlimit, to become someone who is limited, is missing";
  const Program program;
  ASSERT_EQ(runCommand("chmod 777 " + shellQuoted(program.folder.path().string())).status, 0);
  if (runCommand(std::string(kNobody) + SLUICE_PROGRAM + " --version").status != 0)
    GTEST_SKIP() << "the program lies where others may not read";
  for (const int processes : {1, 2, 4, 8}) {
    const CommandResult result =
        drawn(program, "", "p.png",
              kNobody + std::string("prlimit --nproc=") + std::to_string(processes) + " ");
    EXPECT_TRUE(result.status == 0 || result.status == 1)
        << processes << ": " << result.status << result.output;
    EXPECT_NE(result.output.find("sluice: "), std::string::npos) << result.output;
  }
  const CommandResult plenty =
      drawn(program, "", "p.png", kNobody + std::string("prlimit --nproc=64 "));
  EXPECT_EQ(plenty.status, 0) << plenty.output;
}

}  // namespace
}  // namespace sluice
