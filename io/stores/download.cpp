#include "io/stores/download.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include "io/stores/sha256.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"
#include "src/base/files/suffixed_name.h"
#include "src/base/threads/mutex.h"
#include "src/base/threads/worker_pool.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// FILE.part-of says this of the object that FILE.part has the first bytes of.
struct Known {
  std::string name, stamp;
  uint64_t bytes = 0;
  bool comes_whole = false;  // no later run can ask for the rest
  friend bool operator==(const Known&, const Known&) = default;
};

std::optional<Known> readKnown(const fs::path& path) {
  std::ifstream file(path);
  Known known;
  std::string bytes;
  if (!std::getline(file, known.name) || !std::getline(file, bytes) ||
      !std::getline(file, known.stamp))
    return std::nullopt;
  std::string mark;
  known.comes_whole = static_cast<bool>(std::getline(file, mark));
  try {
    known.bytes = std::stoull(bytes);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return known;
}

void writeKnown(const fs::path& path, const Known& known) {
  std::ofstream file(path, std::ios::trunc);
  file << known.name << '\n' << known.bytes << '\n' << known.stamp << '\n';
  if (known.comes_whole) file << "comes whole\n";
  // Only closing writes what is buffered, so that a full disk shows.
  file.close();
  if (!file) fail("{}: cannot be written: {}", path.string(), std::strerror(errno));
}

// The first piece of an object, from an offset on.
struct FirstPiece {
  std::vector<std::byte> bytes;
  uint64_t whole = 0;
  bool comes_in_parts = true;
};

class Download {
 public:
  Download(const StorePlace& object, const fs::path& file, const ExpectedObject& expected,
           const DownloadOptions& options, ProgressMeter& progress)
      : object_(object),
        file_(file),
        expected_(expected),
        options_(options),
        progress_(progress),
        part_path_(suffixedName(file, ".part")),
        known_path_(suffixedName(file, ".part-of")),
        name_(object.name()) {}

  std::optional<Downloaded> run() {
    openPart();
    const std::optional<Known> known = readKnown(known_path_);
    // A file of this name that no fetch has made is somebody's own.
    if (!known && bytesThere() > 0)
      fail("{}: expected nothing of this name, or what a fetch began; move or remove it",
           part_path_.string());
    try {
      return runLocked(known);
    } catch (...) {
      // There is nothing that the next run could go on with.
      if (bytesThere() == 0 || comes_whole_) removeParts();
      throw;
    }
  }

 private:
  std::optional<Downloaded> runLocked(const std::optional<Known>& known) {
    uint64_t there = bytesThere();
    // Another object, or one that cannot be asked for in parts, is begun anew.
    if (!known || known->name != name_ || known->bytes < there || known->comes_whole) there = 0;
    if (there > 0 && there == known->bytes) {
      // All was read, and only the check and the new name are missing.
      return finish(*known, there);
    }
    std::optional<FirstPiece> first = readFirst(there);
    if (!first) {
      removeParts();
      return std::nullopt;
    }
    if (expected_.bytes && first->whole != *expected_.bytes) {
      if (there == 0) removeParts();  // what an earlier try has may be the right file's
      fail("{}: expected {} bytes, found {}; it is not the file that is meant", name_,
           *expected_.bytes, first->whole);
    }
    Known now{name_, object_.store->stampOf(object_.key), first->whole};
    // The object changed since the last run, or the server no longer sends parts: what is there is
    // no start of it.
    if (there > 0 && (*known != now || !first->comes_in_parts)) {
      there = 0;
      first = readFirst(0);
      if (!first) fail("{}: went away while it was fetched", name_);
    }
    if (there == 0 && ftruncate(part_.get(), 0) != 0) failPart();
    comes_whole_ = !first->comes_in_parts && first->bytes.size() < first->whole;
    now.comes_whole = comes_whole_;
    // Before the first byte, so that bytes without an origin are never taken for the object's.
    writeKnown(known_path_, now);
    progress_.expect(first->whole);
    hashStart(there);
    progress_.add(there);
    if (comes_whole_) {
      readAsItComes(now);
    } else {
      append(first->bytes, there);
      readRest(there + first->bytes.size(), now);
    }
    return finish(now, there);
  }

  [[noreturn]] void failPart() const {
    fail("{}: cannot be written: {}", part_path_.string(), std::strerror(errno));
  }
  // Throws Error; nothing of the object stays.
  [[noreturn]] void refuse(const std::string& reason) const {
    removeParts();
    fail("{}: {}", name_, reason);
  }
  void removeParts() const {
    std::error_code ignored;
    fs::remove(part_path_, ignored);
    fs::remove(known_path_, ignored);
  }

  void openPart() {
    part_ = openAlone(part_path_.string());
    if (!part_) fail("{}: another process is fetching it", file_.string());
  }

  uint64_t bytesThere() const {
    struct stat about {};
    return fstat(part_.get(), &about) == 0 ? static_cast<uint64_t>(about.st_size) : 0;
  }

  // Reads one piece. nullopt: there is no object.
  std::optional<FirstPiece> readFirst(uint64_t from) const {
    FirstPiece piece;
    const bool is_there =
        object_.store->read(object_.key, {PieceBytes::From::kStart, from, options_.piece_bytes},
                            [&](const PieceInfo& info) {
                              piece.whole = info.bytes;
                              piece.comes_in_parts = info.comes_in_parts;
                              if (from > 0 && !info.comes_in_parts) return std::span(piece.bytes);
                              piece.bytes.resize(std::min<uint64_t>(
                                  options_.piece_bytes, info.bytes - std::min(info.bytes, from)));
                              return std::span(piece.bytes);
                            });
    return is_there ? std::optional(std::move(piece)) : std::nullopt;
  }

  // Takes the bytes that are there already into the checksum.
  void hashStart(uint64_t bytes) {
    if (!options_.has_checksum) return;
    std::vector<std::byte> buffer(1 << 20);
    if (lseek(part_.get(), 0, SEEK_SET) != 0) failPart();
    while (bytes > 0) {
      options_.stop.throwIfStopped();
      const std::span<std::byte> some =
          std::span(buffer).first(static_cast<size_t>(std::min<uint64_t>(buffer.size(), bytes)));
      if (!readAll(part_.get(), some)) failPart();
      sha_.add(some);
      bytes -= some.size();
    }
  }

  void append(std::span<const std::byte> bytes, uint64_t offset) {
    writeAllAt(part_.get(), bytes, offset,
               fmt::format("{}: write failed; once there is room, the same command {}",
                           part_path_.string(), comes_whole_ ? "begins anew" : "goes on"));
    if (options_.has_checksum) sha_.add(bytes);
    progress_.add(bytes.size());
  }

  // Several threads read pieces, and write them one after the other, so that what is there is
  // always the start of the object.
  void readRest(uint64_t from, const Known& now) {
    if (from >= now.bytes) return;
    const uint64_t pieces = (now.bytes - from + options_.piece_bytes - 1) / options_.piece_bytes;
    std::atomic<uint64_t> next{0};
    WorkerPool pool(static_cast<int>(std::min<uint64_t>(options_.reads, pieces)));
    pool.parallelFor(pool.threads(), [&](int64_t) {
      std::vector<std::byte> buffer;
      try {
        for (uint64_t piece = next++; piece < pieces; piece = next++) {
          const uint64_t offset = from + piece * options_.piece_bytes;
          readPiece(offset, now, buffer);
          if (!waitForTurn(piece)) return;
          append(buffer, offset);
          pass(piece + 1);
        }
      } catch (...) {
        // Else the others would wait for this thread's turn for ever.
        pass(std::nullopt);
        throw;
      }
    });
  }

  void readPiece(uint64_t offset, const Known& now, std::vector<std::byte>& buffer) const {
    options_.stop.throwIfStopped();
    buffer.resize(std::min<uint64_t>(options_.piece_bytes, now.bytes - offset));
    const bool is_there = object_.store->read(
        object_.key, {PieceBytes::From::kStart, offset, buffer.size()}, [&](const PieceInfo& info) {
          if (info.bytes != now.bytes || info.has_changed)
            fail("{}: changed while it was fetched; fetch it again", name_);
          return std::span(buffer);
        });
    if (!is_there) fail("{}: went away while it was fetched", name_);
  }

  // In one piece, of which a later run could not ask for the rest.
  void readAsItComes(Known now) {
    uint64_t got = 0;
    const bool is_there = object_.store->stream(object_.key, {now.stamp, now.bytes},
                                                [&](std::span<const std::byte> bytes) {
                                                  options_.stop.throwIfStopped();
                                                  append(bytes, got);
                                                  got += bytes.size();
                                                });
    if (!is_there || got != now.bytes) fail("{}: changed while it was fetched; try again", name_);
    comes_whole_ = now.comes_whole = false;  // all of it is there
    writeKnown(known_path_, now);
  }

  // False: another thread has failed.
  bool waitForTurn(uint64_t piece) {
    MutexLock lock(mutex_);
    while (turn_ != piece && !has_failed_) changed_.wait(lock);
    return !has_failed_;
  }
  // nullopt: this thread has failed.
  void pass(std::optional<uint64_t> turn) {
    const MutexLock lock(mutex_);
    if (turn)
      turn_ = *turn;
    else
      has_failed_ = true;
    changed_.notifyAll();
  }

  Downloaded finish(const Known& now, uint64_t resumed) {
    Downloaded done{now.bytes, resumed, ""};
    if (options_.has_checksum) {
      if (resumed == now.bytes) hashStart(resumed);
      done.sha256 = sha_.finish();
    }
    if (expected_.bytes && now.bytes != *expected_.bytes)
      refuse(fmt::format("expected {} bytes, found {}", *expected_.bytes, now.bytes));
    if (!expected_.sha256.empty() && done.sha256 != expected_.sha256)
      refuse(fmt::format("expected the SHA-256 {}, found {}; what was fetched is removed",
                         expected_.sha256, done.sha256));
    // The bytes are on the disk before the name says that they are whole.
    if (fsync(part_.get()) != 0) failPart();
    std::error_code error;
    fs::rename(part_path_, file_, error);
    if (error) fail("{}: cannot be written: {}", file_.string(), error.message());
    fs::remove(known_path_, error);
    return done;
  }

  const StorePlace& object_;
  const fs::path& file_;
  const ExpectedObject& expected_;
  const DownloadOptions& options_;
  ProgressMeter& progress_;
  const fs::path part_path_, known_path_;
  const std::string name_;
  Descriptor part_;
  bool comes_whole_ = false;  // see Known
  Sha256 sha_;
  Mutex mutex_;
  Condition changed_;
  uint64_t turn_ SLUICE_GUARDED_BY(mutex_) = 0;
  bool has_failed_ SLUICE_GUARDED_BY(mutex_) = false;
};

}  // namespace

std::optional<Downloaded> download(const StorePlace& object, const fs::path& file,
                                   const ExpectedObject& expected, const DownloadOptions& options,
                                   ProgressMeter& progress) {
  return Download(object, file, expected, options, progress).run();
}

}  // namespace sluice
