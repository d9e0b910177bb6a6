#include "tools/command_line/console.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "src/base/error.h"

namespace sluice {
namespace {

[[noreturn]] void failOutput(int reason) {
  if (reason == EBADF) fail("standard output: closed, so that nothing can be printed");
  failErrno("standard output: cannot be written", reason);
}

}  // namespace

void openStandardStreams() {
  // A file opened later would get a closed stream's number and receive messages as its contents.
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one.
    const int mode = stream == STDERR_FILENO ? O_WRONLY : O_RDONLY;
    if (open("/dev/null", mode) < 0) return;  // nothing to be done without /dev
  }
}

void sayText(std::string_view text) {
  // Names of files may hold escape sequences that change the terminal.
  const std::string shown = withoutControls(text, "\n\t");
  errno = 0;
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) != shown.size()) failOutput(errno);
}

void sayJson(const nlohmann::json& report) {
  sayText(report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void printError(std::string line) {
  line = "sluice: " + withoutControls(line) + "\n";
  // Earlier output stands before the error where both go to one place.
  std::fflush(stdout);
  // Written in one call, so that lines of several processes do not mix.
  while (::write(STDERR_FILENO, line.data(), line.size()) < 0 && errno == EINTR) {
  }
}

void printWarning(const std::string& line) {
  printError("warning: " + line);
}

void printNewWarnings(const std::vector<std::string>& lines, std::vector<std::string>& said) {
  for (const std::string& line : lines) {
    if (std::ranges::find(said, line) != said.end()) continue;
    printWarning(line);
    said.push_back(line);
  }
}

void printNotice(const std::string& line) {
  printError(line);
}

void finishOutput() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) failOutput(errno);
}

}  // namespace sluice
