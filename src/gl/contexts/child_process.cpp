#include "src/gl/contexts/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include "src/base/error.h"

namespace sluice {
namespace {

using Clock = std::chrono::steady_clock;

// The last byte of an answer; an answer that is cut short lacks it.
constexpr char kDone = '\x06', kThrown = '\x15';

void writeAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;
    bytes.remove_prefix(static_cast<size_t>(written));
  }
}

[[noreturn]] void runChild(const std::function<std::string()>& work, int out, pid_t parent) {
  // A child whose driver hangs must not outlive the program.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it ended before the line above
  // A crash is an expected answer, not worth a core file.
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  // A crash shall show as its signal, whatever handlers the program or a sanitizer installed.
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGINT, SIGTERM})
    (void)signal(number, SIG_DFL);
  // Drivers print to both.
  const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  try {
    writeAll(out, work() + kDone);
  } catch (const std::exception& error) {
    writeAll(out, std::string(error.what()) + kThrown);
  }
  _exit(0);  // without the destructors and atexit handlers of the libraries
}

// Everything until the other end closes; false when `deadline` comes first.
bool readAll(int file, Clock::time_point deadline, std::string& bytes) {
  std::array<char, 4096> buffer{};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd waited{file, POLLIN, 0};
    const int ready = poll(&waited, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t got = read(file, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    bytes.append(buffer.data(), static_cast<size_t>(got));
  }
}

std::string describeEnd(int status) {
  if (WIFSIGNALED(status)) return fmt::format("crashed ({})", strsignal(WTERMSIG(status)));
  return fmt::format("ended with status {} and no answer", WEXITSTATUS(status));
}

}  // namespace

ChildAnswer runInChild(const std::function<std::string()>& work,
                       std::chrono::milliseconds timeout) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) failErrno("cannot make a pipe", errno);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) {
    const int error = errno;
    close(ends[0]);
    close(ends[1]);
    failErrno("cannot start a process", error);
  }
  if (child == 0) runChild(work, ends[1], parent);
  // Else the read below would never see the end of the pipe.
  close(ends[1]);
  ChildAnswer result;
  const bool in_time = readAll(ends[0], Clock::now() + timeout, result.answer);
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const char end = result.answer.empty() ? '\0' : result.answer.back();
  if (end == kDone || end == kThrown) result.answer.pop_back();
  result.answered = in_time && end == kDone;
  if (in_time && end == kThrown)
    result.reason = std::move(result.answer);
  else if (!in_time)
    result.reason = fmt::format("gave no answer within {} ms", timeout.count());
  else if (!result.answered)
    result.reason = describeEnd(status);
  if (!result.answered) result.answer.clear();
  return result;
}

}  // namespace sluice
