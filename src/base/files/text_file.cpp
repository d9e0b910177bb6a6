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

// False when nothing came in time.
bool waitForMore(int file, const StopToken& stop) {
  constexpr int kSteps = 100, kStepMs = 100;
  for (int i = 0; i < kSteps; ++i) {
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
  if (fstat(file.number, &status) == 0 && S_ISDIR(status.st_mode))
    fail("{}: expected {}, found a folder", path.string(), what);
  std::string text;
  std::array<char, 64 << 10> piece;
  for (;;) {
    const ssize_t got = read(file.number, piece.data(), piece.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) {
      if (!waitForMore(file.number, stop))
        fail("{}: expected {}, found a pipe into which nothing was written for 10 s", path.string(),
             what);
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
