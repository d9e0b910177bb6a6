#include "tools/interrupt.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "src/base/atomic_file.h"
#include "tests/support/temp_folder.h"

// Each in a process of its own, since what a signal does stays for the rest of it.
namespace sluice {
namespace {

// Ends as the program does when Interrupted comes; with 0 otherwise.
void loopUntilInterrupted(int signal_number) {
  watchForInterruption();
  interruption().throwIfStopped();  // nothing yet
  std::raise(signal_number);
  try {
    interruption().throwIfStopped();
  } catch (const Interrupted& interrupted) {
    std::fprintf(stderr, "%s\n", interrupted.what());
    std::_Exit(interruptionStatus());
  }
  std::_Exit(interruptionStatus());
}

TEST(InterruptDeathTest, aSignalUnwindsTheLoop) {
  EXPECT_EXIT(loopUntilInterrupted(SIGINT), testing::ExitedWithCode(130), "interrupted");
  EXPECT_EXIT(loopUntilInterrupted(SIGTERM), testing::ExitedWithCode(143), "interrupted");
  EXPECT_EXIT(loopUntilInterrupted(SIGHUP), testing::ExitedWithCode(129), "interrupted");
}

TEST(InterruptDeathTest, aSignalThatIsIgnoredStaysSo) {
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        loopUntilInterrupted(SIGHUP);
      },
      testing::ExitedWithCode(0), "");
}

TEST(InterruptDeathTest, aSecondSignalEndsTheProcess) {
  EXPECT_EXIT(
      {
        watchForInterruption();
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::_Exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(InterruptDeathTest, anInterruptedWriterLeavesNoFile) {
  const TempFolder folder;
  const auto path = folder / "out.txt";
  EXPECT_EXIT(
      {
        watchForInterruption();
        try {
          AtomicFile file(path);
          file.write(std::string_view("half"));
          std::raise(SIGTERM);
          interruption().throwIfStopped();
          file.commit();
        } catch (const Interrupted&) {
          std::_Exit(130);
        }
      },
      testing::ExitedWithCode(130), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Interrupt, nothingHappensWithoutASignal) {
  EXPECT_NO_THROW(interruption().throwIfStopped());
}

}  // namespace
}  // namespace sluice
