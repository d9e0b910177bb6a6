#include "tools/command_line/interrupt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "src/base/files/atomic_file.h"
#include "tests/support/temp_folder.h"

// Each in a process of its own, since the effect of a signal stays for the rest of it.
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

// Whatever it is at, and however long that takes: nothing here asks whether to stop.
TEST(InterruptDeathTest, aProcessThatDoesNotAskIsEndedWithItsFilesRemoved) {
  static_assert(kGraceMs < 1000, "ended within a second");
  const TempFolder folder;
  const auto stuck = [&](const char* line) {
    watchForInterruption();
    if (line != nullptr) sayWhenInterrupted(line);
    AtomicFile file(folder / "out.txt"), other(folder / "other.txt"), done(folder / "done.txt");
    file.write(std::string_view("half"));
    done.commit();
    std::raise(SIGTERM);
    for (;;) pause();
  };
  EXPECT_EXIT(stuck(nullptr), testing::ExitedWithCode(143), "^sluice: interrupted\n$");
  EXPECT_EXIT(stuck("gone"), testing::ExitedWithCode(143), "^sluice: gone\n$");
  EXPECT_THAT(filesOf(folder.path()), testing::ElementsAre(testing::Pair("done.txt", "")));
}

TEST(InterruptDeathTest, aSecondSignalLeavesNoFileEither) {
  const TempFolder folder;
  EXPECT_EXIT(
      {
        watchForInterruption();
        AtomicFile file(folder / "out.txt");
        std::raise(SIGINT);
        std::raise(SIGINT);
        std::_Exit(0);
      },
      testing::KilledBySignal(SIGINT), "");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Interrupt, nothingHappensWithoutASignal) {
  EXPECT_NO_THROW(interruption().throwIfStopped());
}

}  // namespace
}  // namespace sluice
