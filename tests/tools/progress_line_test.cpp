#include "tools/command_line/progress_line.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "src/base/threads/clock.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// The output of a child process whose standard error is a terminal while it runs `body`.
template <class F>
std::string onATerminal(F&& body) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0) return "no terminal";
  const std::string other_side = ptsname(terminal);
  const pid_t child = fork();
  if (child == 0) {
    const int side = open(other_side.c_str(), O_RDWR | O_NOCTTY);
    dup2(side, STDERR_FILENO);
    body();
    _exit(0);
  }
  // The other side stays open here, so that the output is still there when the child has ended.
  const int keep = open(other_side.c_str(), O_RDWR | O_NOCTTY);
  int status = 0;
  waitpid(child, &status, 0);
  fcntl(terminal, F_SETFL, O_NONBLOCK);
  std::string text;
  char buffer[4096];
  for (ssize_t got = 0; (got = read(terminal, buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<size_t>(got));
  close(keep);
  close(terminal);
  return status == 0 ? text : "child failed";
}

void addUntilALineIsDue(ProgressMeter& progress) {
  const Stopwatch watch;
  while (watch.seconds() < 0.7) {
    progress.add(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

TEST(ProgressLine, isSilentWhereNobodyWatches) {
  testing::internal::CaptureStderr();
  {
    ProgressMeter progress(progressLine("reading"), 100);
    addUntilALineIsDue(progress);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ProgressLine, showsALineOnATerminalAndEndsItWithWhatWasDone) {
  const std::string text = onATerminal([] {
    ProgressMeter progress(progressLine("reading"), 200);
    progress.expect(1 << 20);
    progress.add(1 << 19);
    addUntilALineIsDue(progress);
  });
  EXPECT_THAT(text, HasSubstr("reading 50 % of 1.0 MiB"));
  EXPECT_THAT(text, HasSubstr("/s"));
  EXPECT_THAT(text, HasSubstr(" s left"));
  EXPECT_THAT(text, testing::ContainsRegex("\r.{3}reading: 512\\.[0-9] KiB in [0-9.]+ s\r\n$"));
}

TEST(ProgressLine, countsPiecesToo) {
  const std::string text = onATerminal([] {
    ProgressMeter progress(progressLine("frames", ProgressUnit::kPieces), 200);
    addUntilALineIsDue(progress);
  });
  EXPECT_THAT(text, HasSubstr(" % of 200, "));
  EXPECT_THAT(text, HasSubstr(" s each, "));
  EXPECT_THAT(text, testing::ContainsRegex("frames: [0-9]+ in [0-9.]+ s"));
}

TEST(ProgressLine, aShareThatWasCutShortIsNotCalledDone) {
  const auto share = [](uint64_t last) {
    return onATerminal([last] {
      const ProgressWatch line = progressLine("drawing", ProgressUnit::kShare);
      std::this_thread::sleep_for(std::chrono::milliseconds(600));
      line(1, 4);
      line(last, 4);
    });
  };
  EXPECT_THAT(share(3), testing::ContainsRegex("drawing: 75 % in [0-9.]+ s"));
  EXPECT_THAT(share(4), testing::ContainsRegex("drawing: done in [0-9.]+ s"));
}

TEST(ProgressLine, aTerminalThatIsGoneIsNoFailure) {
  EXPECT_EQ(onATerminal([] {
              ProgressMeter progress(progressLine("frames"), 200);
              close(STDERR_FILENO);
              addUntilALineIsDue(progress);
            }),
            "");
}

TEST(ProgressLine, shortWorkShowsNothing) {
  EXPECT_EQ(onATerminal([] {
              ProgressMeter progress(progressLine("reading"), 100);
              progress.add(100);
            }),
            "");
}

TEST(ProgressLine, moreThanExpectedStaysAtTheWhole) {
  const std::string text = onATerminal([] {
    ProgressMeter progress(progressLine("reading"), 10);
    progress.add(1000);
    addUntilALineIsDue(progress);
  });
  EXPECT_THAT(text, HasSubstr("reading 100 % of 10 B"));
  EXPECT_THAT(text, HasSubstr(" 0 s left"));
}

}  // namespace
}  // namespace sluice
