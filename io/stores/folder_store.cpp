#include "io/stores/folder_store.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>

#include <cerrno>
#include <memory>
#include <string_view>

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

struct CloseFolder {
  void operator()(DIR* folder) const { closedir(folder); }
};

// Follows links.
bool isFolder(const std::string& parent, const dirent& entry) {
  if (entry.d_type != DT_LNK && entry.d_type != DT_UNKNOWN) return entry.d_type == DT_DIR;
  struct stat status = {};
  const std::string path = parent + '/' + static_cast<const char*>(entry.d_name);
  return stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode);
}

}  // namespace

FolderStore::FolderStore() {
  clock_gettime(CLOCK_REALTIME, &opened_at_);
}

std::string FolderStore::wholeKey(const std::string& key) const {
  return fs::absolute(key).lexically_normal().string();
}

bool FolderStore::has(const std::string& key) {
  std::error_code error;
  const bool is_there = fs::exists(key, error);
  // It is there, and leads nowhere.
  if (error == std::errc::too_many_symbolic_link_levels)
    failErrno(fmt::format("{}: cannot be opened", key), error.value());
  return is_there;
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
  // A store of a million chunks has as many names: fs::directory_iterator takes several times as
  // long for them.
  const std::unique_ptr<DIR, CloseFolder> opened(opendir(folder.c_str()));
  if (opened == nullptr && errno == ENOENT) return;
  errno = opened == nullptr ? errno : 0;
  while (opened != nullptr) {
    const dirent* const entry = readdir(opened.get());
    if (entry == nullptr) break;
    const std::string_view name(entry->d_name);
    if (name == "." || name == "..") continue;
    take({std::string(name), isFolder(folder, *entry)});
    errno = 0;  // readdir() tells an end from a failure by it
  }
  if (errno != 0) failErrno(fmt::format("{}: cannot be listed", folder), errno);
}

StorePlace folderPlace(const fs::path& folder) {
  return {std::make_shared<FolderStore>(), folder.string()};
}

}  // namespace sluice
