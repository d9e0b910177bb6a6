#include "src/base/files/text_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "src/base/error.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

class Opened {
 public:
  explicit Opened(const std::filesystem::path& path)
      // Without waiting, so that a stop reaches a read from a pipe into which nobody writes.
      : number(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (number < 0) failErrno(fmt::format("{}: cannot be read", path.string()), errno);
  }
  ~Opened() { close(number); }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;

  const int number;
};

constexpr int kMostSeconds = 10;         // between two pieces of a writer
constexpr int kMostSecondsToWriter = 3;  // until a writer comes, as long as AtomicFile waits

// Waits until a pipe has bytes or its last writer has gone. False when neither happens in time.
bool waitForMore(int file, int most_seconds, const StopToken& stop) {
  constexpr int kStepMs = 100;
  // Short steps, so that a stop is seen soon.
  for (int i = 0; i < most_seconds * 1000 / kStepMs; ++i) {
    stop.throwIfStopped();
    pollfd waiting{file, POLLIN, 0};
    if (poll(&waiting, 1, kStepMs) > 0) return true;
  }
  return false;
}

}  // namespace

std::string readTextFile(const std::filesystem::path& path, uint64_t most_bytes,
                         std::string_view what, const StopToken& stop) {
  const Opened file(path);
  struct stat status {};
  if (fstat(file.number, &status) != 0)
    failErrno(fmt::format("{}: cannot be read", path.string()), errno);
  if (S_ISDIR(status.st_mode)) fail("{}: expected {}, found a folder", path.string(), what);
  // A pipe that no writer has opened yet reads as if it ended, which poll() tells apart.
  if (S_ISFIFO(status.st_mode) && !waitForMore(file.number, kMostSecondsToWriter, stop))
    fail("{}: expected {}, found a pipe into which nobody writes", path.string(), what);
  std::string text;
  std::array<char, 64 << 10> piece;
  for (;;) {
    const ssize_t got = read(file.number, piece.data(), piece.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) {
      if (!waitForMore(file.number, kMostSeconds, stop))
        fail("{}: expected {}, found a pipe into which nothing was written for {} s", path.string(),
             what, kMostSeconds);
      continue;
    }
    if (got < 0) failErrno(fmt::format("{}: cannot be read", path.string()), errno);
    if (got == 0) return text;
    text.append(piece.data(), static_cast<size_t>(got));
    // Checked as it comes, since a device or a pipe has no size.
    if (text.size() > most_bytes)
      fail("{}: expected {} of at most {}, found more", path.string(), what,
           formatBytes(most_bytes));
  }
}

}  // namespace sluice
