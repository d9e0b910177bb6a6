#include "io/files/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

int64_t modifiedNs(const struct stat& status) {
  return static_cast<int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec;
}

// Never waits: a named pipe opens at once and is then turned away for not being a regular file.
Descriptor openForReading(const std::string& path) {
  Descriptor descriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!descriptor) failErrno(fmt::format("{}: cannot be opened", path), errno);
  return descriptor;
}

}  // namespace

File::File(const std::filesystem::path& path, Keep keep)
    : path_(path.string()), absolute_path_(std::filesystem::absolute(path).lexically_normal()) {
  Descriptor descriptor = openForReading(path_);
  if (fstat(descriptor.get(), &opened_) != 0 || !S_ISREG(opened_.st_mode))
    fail("{}: {}, a regular file is wanted", path_,
         S_ISDIR(opened_.st_mode) ? "is a folder" : "is no regular file");
  if (keep == Keep::kOpen) descriptor_ = std::move(descriptor);
}

std::string File::identity() const {
  return fmt::format("{}|{}|{}", absolute_path_, sizeBytes(), modifiedNs(opened_));
}

void File::checkUnchanged(int descriptor) const {
  struct stat now = {};
  if (fstat(descriptor, &now) != 0) failErrno(fmt::format("{}: fstat failed", path_), errno);
  if (now.st_size != opened_.st_size || modifiedNs(now) != modifiedNs(opened_) ||
      now.st_ino != opened_.st_ino || now.st_dev != opened_.st_dev)
    fail("{}: changed while it was open ({} bytes then, {} now); open it again", path_,
         opened_.st_size, now.st_size);
}

void File::read(uint64_t offset, std::span<const iovec> parts) {
  const Descriptor anew = descriptor_ ? Descriptor() : openForReading(path_);
  const int descriptor = descriptor_ ? descriptor_.get() : anew.get();
  uint64_t wanted = 0;
  for (const iovec& part : parts) wanted += part.iov_len;
  const uint64_t got = readParts(path_, descriptor, offset, parts);
  read_bytes_ += got;
  if (got < wanted)
    fail("{}: short read at offset {}: {} bytes wanted, {} got; the file ends there", path_, offset,
         wanted, got);
  checkUnchanged(descriptor);
}

void File::expectRead(uint64_t offset, uint64_t bytes) {
  if (!descriptor_) return;  // opened for each read: not worth the opening
  posix_fadvise(descriptor_.get(), static_cast<off_t>(offset), static_cast<off_t>(bytes),
                POSIX_FADV_WILLNEED);
}

void File::readAt(uint64_t offset, std::span<std::byte> out) {
  const iovec part{out.data(), out.size()};
  read(offset, std::span(&part, 1));
}

size_t File::readSome(uint64_t offset, std::span<std::byte> out) {
  const uint64_t there = sizeBytes() - std::min(offset, sizeBytes());
  const size_t taken = static_cast<size_t>(std::min<uint64_t>(there, out.size()));
  if (taken > 0) readAt(offset, out.first(taken));
  return taken;
}

}  // namespace sluice
