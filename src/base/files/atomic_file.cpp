#include "src/base/files/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

#include "src/base/error.h"
#include "src/base/files/suffixed_name.h"

namespace sluice {

namespace {

// The path that a symbolic link leads to, whether or not a file is there. The link's own path is
// kept if the system has no name for the target (the pipe behind /dev/stdout).
std::filesystem::path followed(std::filesystem::path path) {
  std::error_code status;
  // Links may lead in a circle; 40 is also the most that Linux follows (path_resolution(7)).
  for (int hops = 0; hops < 40 && std::filesystem::is_symlink(path, status); ++hops) {
    if (std::filesystem::exists(path, status)) {
      const std::filesystem::path target = std::filesystem::canonical(path, status);
      return status ? path : target;
    }
    const std::filesystem::path target = std::filesystem::read_symlink(path, status);
    if (status) break;
    path = path.parent_path() / target;  // the target alone if it is absolute
  }
  return path;
}

// Whether `path` still names the file that is open, and it is ours alone: not a link that somebody
// put there to have another file overwritten.
bool isOwn(int file, const std::filesystem::path& path) {
  struct stat opened {
  }, named{};
  return fstat(file, &opened) == 0 && lstat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino &&
         S_ISREG(opened.st_mode) && opened.st_nlink == 1 && opened.st_uid == geteuid();
}

// The file of this name, empty and locked: made, or taken over from a process that ended without
// removing it, whose lock went with it. -1 with errno EEXIST when somebody is writing to it.
int openOwned(const std::filesystem::path& path) {
  int file = open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
  const bool is_new = file >= 0;
  if (!is_new && errno != EEXIST) return -1;
  if (!is_new) file = open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) {
    if (errno == ENOENT || errno == ELOOP) errno = EEXIST;  // gone again, no file of ours: the next
    return -1;
  }
  // On a file system without locks, only a file that is new is certain to belong to no other
  // process.
  const bool is_locked = flock(file, LOCK_EX | LOCK_NB) == 0;
  const bool is_taken = is_locked ? !isOwn(file, path) : !is_new || errno == EWOULDBLOCK;
  // A new file is empty already, and some file systems cannot cut a file.
  if (!is_taken && (is_new || ftruncate(file, 0) == 0)) return file;
  close(file);
  errno = EEXIST;
  return -1;
}

// A device, or a pipe, whose reader may come a little later but not never.
int openDirectly(const std::filesystem::path& path) {
  constexpr int kTries = 30;
  constexpr auto kPause = std::chrono::milliseconds(100);
  int file = -1;
  for (int i = 0; i < kTries; ++i) {
    // Without waiting: a plain open of a pipe blocks until a reader comes, and no stop ends that.
    file = open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (file >= 0 || errno != ENXIO) break;
    std::this_thread::sleep_for(kPause);
  }
  if (file < 0 && errno == ENXIO)
    failSystem("{}: cannot be written: nobody reads this pipe", path.string());
  if (file >= 0) fcntl(file, F_SETFL, fcntl(file, F_GETFL) & ~O_NONBLOCK);
  return file;
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path) : path_(followed(std::move(path))) {
  // The system would take the name up to there.
  if (const size_t zero = path_.native().find('\0'); zero != std::string::npos)
    failRequest("{}: cannot be written: the name has a zero byte after this",
                path_.native().substr(0, zero));
  std::error_code problem;
  const std::filesystem::file_status status = std::filesystem::status(path_, problem);
  // The temporary name is shorter, so that only the renaming at the end would fail.
  if (problem == std::errc::filename_too_long)
    failErrno(fmt::format("{}: cannot be written", path_.string()), problem.value());
  if (std::filesystem::is_directory(status))
    failRequest("{}: is a folder; give the name of a file", path_.string());
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    // A device or a pipe keeps its place; nothing can be renamed over it.
    temporary_ = path_;
    file_.reset(openDirectly(temporary_));
  } else {
    constexpr int kMostWriters = 1000;
    for (int n = 0; !file_ && n < kMostWriters; ++n) {
      temporary_ = suffixedName(path_, fmt::format(".{}.tmp", n));
      file_.reset(openOwned(temporary_));
      if (!file_ && errno != EEXIST) break;
    }
  }
  if (!file_) failErrno(fmt::format("{}: cannot be written", path_.string()), errno);
  if (temporary_ != path_) name_.emplace(temporary_);
}

AtomicFile::~AtomicFile() {
  if (file_ && temporary_ != path_) unlink(temporary_.c_str());
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  writeAll(file_.get(), bytes, fmt::format("{}: write failed", path_.string()));
}

void AtomicFile::write(std::string_view text) {
  write(std::as_bytes(std::span(text)));
}

void AtomicFile::writeAt(uint64_t offset, std::span<const std::byte> bytes) {
  writeAllAt(file_.get(), bytes, offset, fmt::format("{}: write failed", path_.string()));
}

void AtomicFile::commit() {
  if (temporary_ != path_) {
    // The bytes are on the disk before the name is: a crash leaves the old file or the whole new
    // one.
    if (fsync(file_.get()) != 0) failErrno(fmt::format("{}: write failed", path_.string()), errno);
    if (rename(temporary_.c_str(), path_.c_str()) != 0)
      failErrno(fmt::format("{}: cannot be renamed into place", path_.string()), errno);
    name_.reset();
  }
  file_.reset();
}

}  // namespace sluice
