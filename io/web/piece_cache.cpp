#include "io/web/piece_cache.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/base/files/number_text.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

constexpr std::array<char, 8> kMagic = {'s', 'l', 'p', 'i', 'e', 'c', 'e', '1'};
constexpr uint64_t kBlock = 4096;        // of a file system, roughly
constexpr uint32_t kMostText = 1 << 16;  // of a name or a stamp
constexpr mode_t kFileMode = 0600;
constexpr fs::perms kFolderMode = fs::perms::owner_all;
constexpr const char* kTemporary = "writing-";

// At the start of a file, in this machine's byte order; name, stamp and the piece's bytes follow.
struct Head {
  std::array<char, 8> magic = kMagic;
  uint64_t whole = 0, bytes = 0, checksum = 0;
  uint32_t name_bytes = 0, stamp_bytes = 0;
};

uint64_t onDisk(uint64_t bytes) {
  return (bytes + kBlock - 1) / kBlock * kBlock;
}

uint64_t checksumOf(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

bool readText(int file, uint32_t bytes, std::string& text) {
  if (bytes > kMostText) return false;
  text.resize(bytes);
  return readAll(file, std::as_writable_bytes(std::span(text)));
}

// The bytes that all files have together, in a file whose lock guards it and all changes.
class Usage {
 public:
  explicit Usage(const fs::path& path)
      : file_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kFileMode)) {
    while (file_ && flock(file_.get(), LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  explicit operator bool() const { return static_cast<bool>(file_); }
  // Nothing: it was never written, or is damaged.
  std::optional<uint64_t> read() const {
    std::array<char, 32> text{};
    const ssize_t got = pread(file_.get(), text.data(), text.size(), 0);
    if (got < 2 || text[static_cast<size_t>(got) - 1] != '\n') return std::nullopt;
    return numberIn<uint64_t>({text.data(), static_cast<size_t>(got) - 1});
  }
  // The text always has one length, so that no old digit stays. Throws Error, "<what>: <reason>".
  void write(uint64_t bytes, const std::string& what) const {
    const std::string text = fmt::format("{:020}\n", bytes);
    writeAllAt(file_.get(), std::as_bytes(std::span(text)), 0, what);
  }

 private:
  Descriptor file_;
};

// Removes a file that a process was writing, if that process has ended: its lock went with it.
bool removeDead(const fs::path& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  return file && flock(file.get(), LOCK_EX | LOCK_NB) == 0 && unlink(path.c_str()) == 0;
}

// Makes and locks a file. Nothing: another thread is writing it. A dead process may have had the
// same number, as the first process of each container has. Throws Error, "<what>: <reason>".
Descriptor makeLocked(const fs::path& path, const std::string& what) {
  Descriptor file;
  do {
    file.reset(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode));
    if (!file && errno != EEXIST) failErrno(what, errno);
  } while (!file && removeDead(path));
  if (file) flock(file.get(), LOCK_EX | LOCK_NB);
  return file;
}

// Removes a file at the end of a scope, unless it stays.
class Temporary {
 public:
  explicit Temporary(const fs::path& path) : path_(path) {}
  ~Temporary() {
    if (!stays_) unlink(path_.c_str());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  void stays() { stays_ = true; }

 private:
  const fs::path& path_;
  bool stays_ = false;
};

struct OnDisk {
  fs::path path;
  uint64_t bytes = 0;
  timespec used{};
};

// All files of the cache; those that a dead process was writing are removed.
std::vector<OnDisk> filesIn(const fs::path& folder) {
  std::vector<OnDisk> files;
  std::error_code ignored;
  for (auto entry = fs::directory_iterator(folder, ignored); entry != fs::directory_iterator();
       entry.increment(ignored)) {
    struct stat about {};
    if (lstat(entry->path().c_str(), &about) != 0 || !S_ISREG(about.st_mode)) continue;
    if (entry->path().filename().string().starts_with(kTemporary) && removeDead(entry->path()))
      continue;
    files.push_back({entry->path(), onDisk(static_cast<uint64_t>(about.st_size)), about.st_mtim});
  }
  return files;
}

}  // namespace

bool CachedPiece::read(std::span<std::byte> out) const {
  return out.size() == bytes_ && readAll(file_.get(), out) && checksumOf(out) == checksum_;
}

PieceCache::PieceCache(fs::path folder, uint64_t budget_bytes)
    : folder_(std::move(folder)), budget_(budget_bytes) {
  if (folder_.empty()) failSystem("{}", kNoCacheFolder);
  std::error_code error;
  const bool is_new = fs::create_directories(folder_ / "pieces", error);
  if (is_new) fs::permissions(folder_, kFolderMode, error);
  if (!error && !Usage(folder_ / "usage")) error.assign(errno, std::generic_category());
  if (error)
    failSystem(
        "{}: expected a folder for the cache of web pages' pieces, found: {}; name another one "
        "with --cache-dir",
        folder_.string(), error.message());
}

fs::path PieceCache::fileOf(const std::string& name) const {
  const XXH128_hash_t hash = XXH3_128bits(name.data(), name.size());
  return folder_ / "pieces" / fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::optional<CachedPiece> PieceCache::find(const std::string& name) {
  const fs::path path = fileOf(name);
  Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file) return std::nullopt;
  Head head;
  std::string named, stamp;
  const int number = file.get();
  // The name within the file tells whether its hash is that of another piece.
  if (!readAll(number, std::as_writable_bytes(std::span(&head, 1))) || head.magic != kMagic ||
      !readText(number, head.name_bytes, named) || named != name ||
      !readText(number, head.stamp_bytes, stamp)) {
    remove(name);
    return std::nullopt;
  }
  futimens(number, nullptr);  // used now
  return CachedPiece(std::move(file), std::move(stamp), head.whole, head.bytes, head.checksum);
}

void PieceCache::remove(const std::string& name) {
  unlink(fileOf(name).c_str());  // counted still: too much, until room is made
}

uint64_t PieceCache::shrinkTo(uint64_t most) {
  std::vector<OnDisk> files = filesIn(folder_ / "pieces");
  std::sort(files.begin(), files.end(), [](const OnDisk& a, const OnDisk& b) {
    return std::pair(a.used.tv_sec, a.used.tv_nsec) < std::pair(b.used.tv_sec, b.used.tv_nsec);
  });
  uint64_t bytes = 0;
  for (const OnDisk& file : files) bytes += file.bytes;
  for (const OnDisk& file : files) {
    if (bytes <= most) break;
    if (file.path.filename().string().starts_with(kTemporary)) continue;
    if (unlink(file.path.c_str()) == 0) bytes -= file.bytes;
  }
  return bytes;
}

Descriptor PieceCache::reserve(const fs::path& replaced, const fs::path& temporary,
                               uint64_t bytes) {
  const Usage usage(folder_ / "usage");
  if (!usage) failErrno(folder_.string(), errno);
  std::optional<uint64_t> used = usage.read();
  struct stat old {};
  if (used && lstat(replaced.c_str(), &old) == 0 && unlink(replaced.c_str()) == 0)
    used = *used - std::min(*used, onDisk(static_cast<uint64_t>(old.st_size)));
  const uint64_t size = onDisk(bytes);
  if (!used || *used + size > budget_) {
    // A tenth at once, so that the next ones find room without looking at every file.
    const uint64_t most = std::min(budget_ - size, budget_ - budget_ / 10);
    used = shrinkTo(used ? most : budget_ - size);
    if (*used > budget_ - size) return Descriptor();
  }
  const std::string what = folder_.string();
  Descriptor file = makeLocked(temporary, what);
  if (!file) return file;
  Temporary unless_full(temporary);
  usage.write(*used + size, what);
  const int fault = posix_fallocate(file.get(), 0, static_cast<off_t>(bytes));
  if (fault != 0) failErrno(what, fault);
  unless_full.stays();
  return file;
}

std::optional<std::string> PieceCache::keep(const std::string& name, const std::string& stamp,
                                            uint64_t whole, std::span<const std::byte> bytes) {
  const fs::path path = fileOf(name);
  const Head head{.whole = whole,
                  .bytes = bytes.size(),
                  .checksum = checksumOf(bytes),
                  .name_bytes = static_cast<uint32_t>(name.size()),
                  .stamp_bytes = static_cast<uint32_t>(stamp.size())};
  const uint64_t size = sizeof head + name.size() + stamp.size() + bytes.size();
  if (onDisk(size) > budget_ || std::max(name.size(), stamp.size()) > kMostText)
    return std::nullopt;
  const fs::path temporary =
      folder_ / "pieces" / fmt::format("{}{}-{}", kTemporary, getpid(), path.filename().string());
  const std::string what = folder_.string();
  try {
    const Descriptor file = reserve(path, temporary, size);
    if (!file) return std::nullopt;
    Temporary unless_whole(temporary);
    writeAll(file.get(), std::as_bytes(std::span(&head, 1)), what);
    writeAll(file.get(), std::as_bytes(std::span(name)), what);
    writeAll(file.get(), std::as_bytes(std::span(stamp)), what);
    writeAll(file.get(), bytes, what);
    const Usage still(folder_ / "usage");  // whoever counts the files sees one name or the other
    if (rename(temporary.c_str(), path.c_str()) != 0) failErrno(what, errno);
    unless_whole.stays();
  } catch (const Error& error) {
    return error.what();
  }
  return std::nullopt;
}

}  // namespace sluice
