#include "src/base/files/descriptor.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "src/base/error.h"

namespace sluice {

void Descriptor::reset(int number) {
  if (number_ >= 0) close(number_);
  number_ = number;
}

namespace {

// `write` takes the remaining bytes and returns how many of them it wrote.
template <class Write>
void writeWhole(std::span<const std::byte> bytes, const std::string& what, Write&& write) {
  while (!bytes.empty()) {
    const ssize_t written = write(bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) failErrno(what, errno);
    bytes = bytes.subspan(static_cast<size_t>(written));
  }
}

}  // namespace

void writeAll(int descriptor, std::span<const std::byte> bytes, const std::string& what) {
  writeWhole(bytes, what, [descriptor](std::span<const std::byte> left) {
    return ::write(descriptor, left.data(), left.size());
  });
}

void writeAllAt(int descriptor, std::span<const std::byte> bytes, uint64_t offset,
                const std::string& what) {
  const uint64_t end = offset + bytes.size();
  writeWhole(bytes, what, [descriptor, end](std::span<const std::byte> left) {
    return pwrite(descriptor, left.data(), left.size(), static_cast<off_t>(end - left.size()));
  });
}

bool lockAlone(int descriptor, const std::string& path) {
  while (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno != EINTR)
      failErrno(fmt::format("{}: cannot be locked against other processes, as it has to be; choose "
                            "a folder on another file system",
                            path),
                errno);
  }
  return true;
}

Descriptor openAlone(const std::string& path) {
  constexpr mode_t kFileMode = 0644;
  constexpr int kMostTries = 1000;
  for (int tries = 0; tries < kMostTries; ++tries) {
    Descriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kFileMode));
    if (!file) failErrno(fmt::format("{}: cannot be written", path), errno);
    struct stat opened {
    }, named{};
    fstat(file.get(), &opened);
    try {
      if (!lockAlone(file.get(), path)) return Descriptor();
    } catch (const Error&) {
      // An empty file is one that this call has made.
      if (opened.st_size == 0) unlink(path.c_str());
      throw;
    }
    // Between the two calls, the process that had the file may have ended its work.
    if (stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
        opened.st_ino == named.st_ino)
      return file;
  }
  fail("{}: other processes begin and end it all the time; try again", path);
}

bool readAll(int descriptor, std::span<std::byte> out) {
  while (!out.empty()) {
    const ssize_t got = ::read(descriptor, out.data(), out.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    out = out.subspan(static_cast<size_t>(got));
  }
  return true;
}

}  // namespace sluice
