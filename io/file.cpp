#include "io/file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "src/base/error.h"

namespace sluice {
namespace {

int64_t modifiedNs(const struct stat& status) {
  return static_cast<int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec;
}

// Never waits: a named pipe opens at once and is then turned away for not being a regular file.
int openForReading(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) failErrno(fmt::format("{}: cannot be opened", path), errno);
  return descriptor;
}

}  // namespace

class File::Descriptor {
 public:
  explicit Descriptor(const File& file)
      : number(file.descriptor_ >= 0 ? file.descriptor_ : openForReading(file.path_)),
        owned_(file.descriptor_ < 0) {}
  ~Descriptor() {
    if (owned_) close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  const int number;

 private:
  const bool owned_;
};

File::File(const std::filesystem::path& path, Keep keep)
    : path_(path.string()), absolute_path_(std::filesystem::absolute(path).lexically_normal()) {
  const int descriptor = openForReading(path_);
  const bool known = fstat(descriptor, &opened_) == 0;
  if (keep == Keep::kOpen && known && S_ISREG(opened_.st_mode)) {
    descriptor_ = descriptor;
    return;
  }
  close(descriptor);
  if (!known || !S_ISREG(opened_.st_mode))
    fail("{}: {}, a regular file is wanted", path_,
         S_ISDIR(opened_.st_mode) ? "is a folder" : "is no regular file");
}

File::~File() {
  if (descriptor_ >= 0) close(descriptor_);
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
  const Descriptor descriptor(*this);
  uint64_t wanted = 0;
  for (const iovec& part : parts) wanted += part.iov_len;
  const uint64_t got = readParts(path_, descriptor.number, offset, parts);
  read_bytes_ += got;
  if (got < wanted)
    fail("{}: short read at offset {}: {} bytes wanted, {} got; the file ends there", path_, offset,
         wanted, got);
  checkUnchanged(descriptor.number);
}

void File::expectRead(uint64_t offset, uint64_t bytes) {
  if (descriptor_ < 0) return;  // opened for each read: not worth the opening
  posix_fadvise(descriptor_, static_cast<off_t>(offset), static_cast<off_t>(bytes),
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
