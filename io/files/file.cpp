#include "io/files/file.h"

#include <fcntl.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kPageBytes = 4096;

int64_t inNs(const timespec& time) {
  return static_cast<int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

// Never waits: a named pipe opens at once and is then turned away for not being a regular file.
Descriptor openForReading(const std::string& path) {
  Descriptor descriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!descriptor) failErrno(fmt::format("{}: cannot be opened", path), errno);
  return descriptor;
}

}  // namespace

std::string describeStatus(const struct stat& status) {
  // Programs that copy or unpack files may set the time of the last write back. The time of the
  // last change of the status cannot be set.
  return fmt::format("{}|{}|{}|{}", status.st_size, inNs(status.st_mtim), inNs(status.st_ctim),
                     status.st_ino);
}

File::File(const std::filesystem::path& path, Keep keep)
    : path_(path.string()), absolute_path_(std::filesystem::absolute(path).lexically_normal()) {
  Descriptor descriptor = openForReading(path_);
  if (fstat(descriptor.get(), &opened_) != 0 || !S_ISREG(opened_.st_mode))
    fail("{}: {}, a regular file is wanted", path_,
         S_ISDIR(opened_.st_mode) ? "is a folder" : "is no regular file");
  if (keep == Keep::kOpen) descriptor_ = std::move(descriptor);
}

std::string File::identity(int sampled_pages) const {
  return fmt::format("{}|{}|{:016x}", absolute_path_, describeStatus(opened_),
                     checksumOfSample(sampled_pages));
}

uint64_t File::checksumOfSample(int pages) const {
  const uint64_t in_file = (sizeBytes() + kPageBytes - 1) / kPageBytes;
  const uint64_t sampled = std::min(static_cast<uint64_t>(pages), in_file);
  if (sampled == 0) return 0;
  const Descriptor anew = descriptor_ ? Descriptor() : openForReading(path_);
  const int descriptor = descriptor_ ? descriptor_.get() : anew.get();
  const auto offsetOf = [&](uint64_t i) {
    // Sizes go from the first page to the last one in equal steps.
    return (sampled == 1 ? 0 : i * (in_file - 1) / (sampled - 1)) * kPageBytes;
  };
  // A disk fetches all of them at once.
  for (uint64_t i = 0; i < sampled; ++i)
    posix_fadvise(descriptor, static_cast<off_t>(offsetOf(i)), static_cast<off_t>(kPageBytes),
                  POSIX_FADV_WILLNEED);
  uint64_t checksum = 0;
  std::array<std::byte, kPageBytes> page;
  for (uint64_t i = 0; i < sampled; ++i) {
    const iovec part{page.data(), page.size()};
    const uint64_t got = readParts(path_, descriptor, offsetOf(i), std::span(&part, 1));
    checksum = XXH3_64bits_withSeed(page.data(), got, checksum);
  }
  return checksum;
}

void File::checkUnchanged(int descriptor) const {
  struct stat now = {};
  if (fstat(descriptor, &now) != 0) failErrno(fmt::format("{}: fstat failed", path_), errno);
  requireSame(opened_, now);
}

void File::requireSame(const struct stat& before, const struct stat& now) const {
  // A file that was replaced or written meanwhile would give voxels that the index does not know.
  // The time of the status' change is left out: a link or other rights change no voxels.
  if (now.st_size != before.st_size || inNs(now.st_mtim) != inNs(before.st_mtim) ||
      now.st_ino != before.st_ino || now.st_dev != before.st_dev)
    fail("{}: changed while it was open ({} bytes then, {} now); open it again", path_,
         before.st_size, now.st_size);
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
  // After the read, so that a change during it is found.
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
