#include "src/base/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "src/base/error.h"

namespace sluice {

namespace {

// The file that a symbolic link stands for, whether it exists or not. What the system gives no way
// to name (the pipe behind /dev/stdout) keeps the name of the link.
std::filesystem::path followed(std::filesystem::path path) {
  std::error_code status;
  for (int hops = 0; hops < 40 && std::filesystem::is_symlink(path, status); ++hops) {
    if (std::filesystem::exists(path, status)) {
      const std::filesystem::path target = std::filesystem::canonical(path, status);
      return status ? path : target;
    }
    const std::filesystem::path target = std::filesystem::read_symlink(path, status);
    if (status) break;
    path = path.parent_path() / target;  // the target alone where it is absolute
  }
  return path;
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path path) : path_(followed(std::move(path))) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path_, ignored);
  if (std::filesystem::is_directory(status))
    fail("{}: is a folder; give the name of a file", path_.string());
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    temporary_ = path_;
    file_ = open(temporary_.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    // A name of its own, also beside what a process that was killed left behind.
    for (int n = 0; file_ < 0; ++n) {
      temporary_ = fmt::format("{}.{}-{}.tmp", path_.string(), getpid(), n);
      file_ = open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
      if (file_ < 0 && errno != EEXIST) break;
    }
  }
  if (file_ < 0) failErrno(fmt::format("{}: cannot be written", path_.string()), errno);
}

AtomicFile::~AtomicFile() {
  if (file_ < 0) return;
  close(file_);
  if (temporary_ != path_) unlink(temporary_.c_str());
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) failErrno(fmt::format("{}: write failed", path_.string()), errno);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

void AtomicFile::write(std::string_view text) {
  write(std::as_bytes(std::span(text)));
}

void AtomicFile::commit() {
  if (temporary_ != path_) {
    if (fsync(file_) != 0) failErrno(fmt::format("{}: write failed", path_.string()), errno);
    if (rename(temporary_.c_str(), path_.c_str()) != 0)
      failErrno(fmt::format("{}: cannot be renamed into place", path_.string()), errno);
  }
  close(file_);
  file_ = -1;
}

}  // namespace sluice
