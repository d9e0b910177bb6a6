// File: a regular file opened for reading at positions, which counts the bytes that it reads.
//
// There is no file position, so any number of threads may read at once. The file is expected to
// stay as it was when opened: a file that is truncated, rewritten or (if it is opened again for
// each read) replaced in the meantime is an Error, never a mixture of old and new voxels.
#pragma once

#include <sys/stat.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "io/files/byte_store.h"
#include "src/base/files/descriptor.h"

namespace sluice {

// "<size>|<modification time in ns>|<change time in ns>|<inode>": the parts of a file's status that
// tell one version of it from another.
std::string describeStatus(const struct stat& status);

class File : public ByteStore {
 public:
  // Volumes of thousands of files would use up the file descriptors: their files are opened anew
  // for each read.
  enum class Keep { kOpen, kClosed };

  // Throws Error when there is no such file, it may not be read, or it is no regular file.
  explicit File(const std::filesystem::path& path, Keep keep = Keep::kOpen);
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void read(uint64_t offset, std::span<const iovec> parts) override;
  void expectRead(uint64_t offset, uint64_t bytes) override;
  // The same into one piece of memory.
  void readAt(uint64_t offset, std::span<std::byte> out);
  // Reads up to out.size() bytes; returns how many the file had from `offset` on.
  size_t readSome(uint64_t offset, std::span<std::byte> out);

  uint64_t storedBytesRead() const override { return read_bytes_.load(); }
  std::vector<std::string> paths() const override { return {path_}; }
  // As of the opening.
  const struct stat& status() const { return opened_; }
  // Throws Error if the file that was opened is not the one that had this status, or was written
  // since.
  void requireSame(const struct stat& before) const { requireSame(before, opened_); }
  uint64_t sizeBytes() const { return static_cast<uint64_t>(opened_.st_size); }
  // The path as it was given: for messages.
  const std::string& path() const { return path_; }
  // "<absolute path>|<size>|<modification time in ns>|<change time in ns>|<inode>|<checksum>" as of
  // the opening. The checksum covers `sampled_pages` pages, evenly spread from the first to the
  // last: `cp -p` and tar restore the modification time, and some file systems have no honest
  // change time or inode. The pages are not counted as read. Throws Error when they cannot be read.
  std::string identity(int sampled_pages = kSampledPages) const;
  static constexpr int kSampledPages = 16;

 private:
  void checkUnchanged(int descriptor) const;
  void requireSame(const struct stat& before, const struct stat& now) const;
  uint64_t checksumOfSample(int pages) const;

  const std::string path_;
  const std::string absolute_path_;
  Descriptor descriptor_;    // constant after construction; none: opened for each read
  struct stat opened_ = {};  // constant after construction
  std::atomic<uint64_t> read_bytes_{0};
};

}  // namespace sluice
