// A program of its own, because probing comes before any context of the process.
#include "src/gl/contexts/probe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <iostream>
#include <sstream>

#include "src/base/error.h"
#include "src/gl/contexts/child_process.h"

namespace sluice {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

std::string openLibraries() {
  std::ifstream maps("/proc/self/maps");
  std::ostringstream text;
  text << maps.rdbuf();
  return text.str();
}

TEST(RunInChild, bringsBackAnAnswerLongerThanAPipe) {
  constexpr size_t kLength = 1'000'000;
  const ChildAnswer result = runInChild([] { return std::string(kLength, 'a'); }, minutes(1));
  EXPECT_TRUE(result.answered);
  EXPECT_EQ(result.answer, std::string(kLength, 'a'));
  EXPECT_EQ(result.reason, "");
}

TEST(RunInChild, anEmptyAnswerIsAnAnswer) {
  const ChildAnswer result = runInChild([] { return std::string(); }, minutes(1));
  EXPECT_TRUE(result.answered);
  EXPECT_EQ(result.answer, "");
}

TEST(RunInChild, survivesACrash) {
  const ChildAnswer result = runInChild(
      []() -> std::string {
        (void)raise(SIGSEGV);
        return "";
      },
      minutes(1));
  EXPECT_FALSE(result.answered);
  EXPECT_EQ(result.reason, "crashed (Segmentation fault)");
}

TEST(RunInChild, endsWhatHangs) {
  const ChildAnswer result = runInChild(
      []() -> std::string {
        for (;;) pause();
      },
      milliseconds(50));
  EXPECT_FALSE(result.answered);
  EXPECT_EQ(result.reason, "gave no answer within 50 ms");
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);  // no process is left
  EXPECT_EQ(errno, ECHILD);
}

TEST(RunInChild, tellsWhatWasThrown) {
  const ChildAnswer result =
      runInChild([]() -> std::string { fail("no driver for {}", "card0"); }, minutes(1));
  EXPECT_FALSE(result.answered);
  EXPECT_EQ(result.reason, "no driver for card0");
  EXPECT_EQ(result.answer, "");
}

TEST(RunInChild, anExitIsNoAnswer) {
  const ChildAnswer result = runInChild([]() -> std::string { _exit(3); }, minutes(1));
  EXPECT_FALSE(result.answered);
  EXPECT_EQ(result.reason, "ended with status 3 and no answer");
}

TEST(RunInChild, printsNothing) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  runInChild(
      [] {
        std::cerr << "libEGL warning" << std::endl;
        std::cout << "hello" << std::endl;
        return std::string();
      },
      minutes(1));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(ProbeGl, tellsOfEachWayWhatItIsOrWhyNot) {
  const std::vector<GlProbe> probes = probeGl();
  ASSERT_GE(probes.size(), 2U);
  EXPECT_EQ(probes[0].backend, "osmesa");
  for (const GlProbe& probe : probes) {
    SCOPED_TRACE(probe.backend + " " + probe.device);
    EXPECT_THAT(probe.backend, AnyOf("osmesa", "egl"));
    EXPECT_EQ(probe.reason == "", probe.works);
    EXPECT_EQ(probe.renderer != "", probe.works);
    EXPECT_EQ(probe.version != "", probe.works);
    EXPECT_EQ(probe.max_3d_texture_size >= 256, probe.works);
  }
}

// Nothing is linked at build time, and libraries opened by probing stay in the children.
TEST(ProbeGl, leavesNoLibraryInThisProcess) {
  probeGl();
  EXPECT_THAT(openLibraries(), AllOf(Not(HasSubstr("libOSMesa")), Not(HasSubstr("libEGL")),
                                     Not(HasSubstr("libGL"))));
}

TEST(ProbeGl, agreesWithTheContextsThatCanBeMade) {
  bool has_osmesa = false, has_egl = false;
  for (const GlProbe& probe : probeGl({}, minutes(1)))
    (probe.backend == "egl" ? has_egl : has_osmesa) |= probe.works;
  for (const GlChoice choice : {GlChoice::kOsmesa, GlChoice::kEgl}) {
    const bool expected = choice == GlChoice::kEgl ? has_egl : has_osmesa;
    const ChildAnswer made =
        runInChild([&] { return createContext(choice)->renderer(); }, minutes(1));
    EXPECT_EQ(made.answered, expected) << name(choice) << ": " << made.reason;
  }
}

TEST(ProbeGl, tellsWhatIsMissing) {
  GlLibraries none;
  none.osmesa = {"libNoSuchMesa.so.1"};
  none.egl = {"libNoSuchEgl.so.1"};
  const std::vector<GlProbe> probes = probeGl(none);
  ASSERT_EQ(probes.size(), 2U);
  EXPECT_THAT(probes[0].reason, AllOf(HasSubstr("libNoSuchMesa.so.1"), HasSubstr("libosmesa6")));
  EXPECT_THAT(probes[1].reason, AllOf(HasSubstr("libNoSuchEgl.so.1"), HasSubstr("libegl1")));
}

TEST(ProbeGl, survivesALibraryThatCrashesOrHangs) {
  GlLibraries broken;
  broken.osmesa = {SLUICE_CRASHING_LIBRARY};
  broken.egl = {SLUICE_HANGING_LIBRARY};
  const std::vector<GlProbe> probes = probeGl(broken, milliseconds(2000));
  ASSERT_EQ(probes.size(), 2U);
  EXPECT_EQ(probes[0].reason, "crashed (Aborted)");
  EXPECT_EQ(probes[1].reason, "gave no answer within 2000 ms");
}

}  // namespace
}  // namespace sluice
