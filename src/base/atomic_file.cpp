#include "src/base/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "src/base/error.h"

namespace sluice {

AtomicFile::AtomicFile(std::filesystem::path path)
    : path_(std::move(path)), temporary_(fmt::format("{}.{}.tmp", path_.string(), getpid())) {
  file_ = open(temporary_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0666);
  if (file_ < 0) failErrno(fmt::format("{}: cannot be written", path_.string()), errno);
}

AtomicFile::~AtomicFile() {
  if (file_ < 0) return;
  close(file_);
  unlink(temporary_.c_str());
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
  if (fsync(file_) != 0) failErrno(fmt::format("{}: write failed", path_.string()), errno);
  if (rename(temporary_.c_str(), path_.c_str()) != 0)
    failErrno(fmt::format("{}: cannot be renamed into place", path_.string()), errno);
  close(file_);
  file_ = -1;
}

}  // namespace sluice
