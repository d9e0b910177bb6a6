#include "io/stores/folder_store.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>

#include <cerrno>

#include "io/files/byte_store.h"
#include "io/files/file.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

bool isBefore(const timespec& a, const timespec& b) {
  return a.tv_sec < b.tv_sec || (a.tv_sec == b.tv_sec && a.tv_nsec < b.tv_nsec);
}

// Written after `opened_at`. A time in the future is a clock that is wrong, not a change.
bool isNewer(const struct stat& status, const timespec& opened_at) {
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  return isBefore(opened_at, status.st_mtim) && isBefore(status.st_mtim, now);
}

}  // namespace

FolderStore::FolderStore() {
  clock_gettime(CLOCK_REALTIME, &opened_at_);
}

std::string FolderStore::wholeKey(const std::string& key) const {
  return fs::absolute(key).lexically_normal().string();
}

bool FolderStore::has(const std::string& key) {
  std::error_code ignored;
  return fs::exists(key, ignored);
}

bool FolderStore::read(const std::string& key, const PieceBytes& wanted, const Room& room) {
  const Descriptor file(open(key.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) {
    if (errno == ENOENT || errno == ENOTDIR) return false;
    failErrno(fmt::format("{}: cannot be opened", key), errno);
  }
  struct stat status = {};
  if (fstat(file.get(), &status) != 0) failErrno(key, errno);
  if (!S_ISREG(status.st_mode)) fail("{}: expected a file, found no regular one", key);
  const auto bytes = static_cast<uint64_t>(status.st_size);
  const std::span<std::byte> out = room({bytes, isNewer(status, opened_at_)});
  uint64_t from = wanted.offset;
  if (wanted.from == PieceBytes::From::kEnd) {
    if (bytes < out.size())
      fail("{}: expected at least {} bytes, found {}; it was cut short", key, out.size(), bytes);
    from = bytes - out.size();
  }
  const iovec part{out.data(), out.size()};
  const uint64_t got = readParts(key, file.get(), from, std::span(&part, 1));
  if (got < out.size())
    fail("{}: expected {} bytes, found {}; it was cut short", key, from + out.size(), from + got);
  return true;
}

std::string FolderStore::stampOf(const std::string& key) {
  struct stat status = {};
  return stat(key.c_str(), &status) == 0 ? describeStatus(status) : "none";
}

void FolderStore::list(const std::string& folder,
                       const std::function<void(const Entry& entry)>& take) {
  std::error_code status;
  fs::directory_iterator entries(folder, status);
  if (status == std::errc::no_such_file_or_directory) return;
  for (; !status && entries != fs::directory_iterator(); entries.increment(status)) {
    std::error_code unknown;
    take({entries->path().filename().string(), entries->is_directory(unknown)});
  }
  if (status) fail("{}: cannot be listed: {}", folder, status.message());
}

StorePlace folderPlace(const fs::path& folder) {
  return {std::make_shared<FolderStore>(), folder.string()};
}

}  // namespace sluice
