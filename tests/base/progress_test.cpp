#include "src/base/progress.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace sluice {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

// What a child whose standard error is a terminal prints while it runs `body`.
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
  // The other side stays open here, so that what was printed is still there when the child ended.
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

void addUntilALineIsDue(Progress& progress) {
  const Stopwatch watch;
  while (watch.seconds() < 0.7) {
    progress.add(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

TEST(Progress, isSilentWhereNobodyWatches) {
  testing::internal::CaptureStderr();
  {
    Progress progress("reading", 100);
    addUntilALineIsDue(progress);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Progress, showsALineOnATerminalAndWipesIt) {
  const std::string text = onATerminal([] {
    Progress progress("reading", 200);
    progress.expect(1 << 20);
    progress.add(1 << 19);
    addUntilALineIsDue(progress);
  });
  EXPECT_THAT(text, HasSubstr("reading 50 % of 1.0 MiB"));
  EXPECT_THAT(text, HasSubstr("/s"));
  EXPECT_THAT(text, HasSubstr(" s left"));
  EXPECT_THAT(text, EndsWith("\r\033[K"));
}

TEST(Progress, shortWorkShowsNothing) {
  EXPECT_EQ(onATerminal([] {
              Progress progress("reading", 100);
              progress.add(100);
            }),
            "");
}

TEST(Progress, moreThanExpectedStaysAtTheWhole) {
  const std::string text = onATerminal([] {
    Progress progress("reading", 10);
    progress.add(1000);
    addUntilALineIsDue(progress);
  });
  EXPECT_THAT(text, HasSubstr("reading 100 % of 10 B"));
  EXPECT_THAT(text, HasSubstr(" 0 s left"));
}

TEST(Progress, takesBytesFromManyThreads) {
  Progress progress("reading", 8000);
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i) {
        progress.expect(1);
        progress.add(1);
      }
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace sluice
