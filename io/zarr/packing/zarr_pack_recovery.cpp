// How an unfinished pack is taken up again: after a kill, a power cut or a full disk, and only by
// one process at a time.
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/files/file.h"
#include "io/zarr/packing/zarr_pack_folder.h"
#include "io/zarr/reading/crc32c.h"
#include "src/base/error.h"
#include "src/base/files/atomic_file.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

}  // namespace

void ZarrPackFolder::makeFolders(const fs::path& path) {
  std::error_code status;
  fs::create_directories(path, status);
  if (status) failSystem("{}: cannot be made: {}", path.string(), status.message());
}

// The process that finishes removes the file that others may have opened: they then try again.
void ZarrPackFolder::lock() {
  const std::string path = (folder_ / "lock").string();
  for (;;) {
    makeFolders(folder_);
    Descriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
    if (!file && errno == ENOENT) continue;
    if (!file) failErrno(fmt::format("{}: cannot be written", path), errno);
    bool is_ours = false;
    try {
      is_ours = lockAlone(file.get(), path);
    } catch (const Error&) {
      // Nothing was packed to a folder that cannot be locked, and nothing will be.
      std::error_code ignored;
      fs::remove(path, ignored);
      fs::remove(folder_, ignored);  // unless something is in it
      throw;
    }
    if (!is_ours)
      failRequest("{}: another sluice is packing to it; wait for it or choose another name",
                  output_.string());
    // Else the lock is on a file that another process has removed since.
    struct stat opened = {}, named = {};
    if (fstat(file.get(), &opened) == 0 && stat(path.c_str(), &named) == 0 &&
        opened.st_ino == named.st_ino) {
      lock_ = std::move(file);
      return;
    }
  }
}

void ZarrPackFolder::checkParameters(const std::string& source_identity,
                                     const std::string& parameters, BegunByOthers others) {
  const fs::path path = folder_ / "pack.json";
  const nlohmann::json ours{{"source", source_identity}, {"parameters", parameters}};
  const std::string text = ours.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string reason;
  if (fs::exists(path)) {
    File file(path);
    std::string found(std::min<uint64_t>(file.sizeBytes(), 1 << 20), '\0');
    file.readAt(0, std::as_writable_bytes(std::span(found)));
    if (found == text) return;
    // Damaged by a power cut, it may be no JSON.
    const nlohmann::json theirs = nlohmann::json::parse(found, nullptr, false);
    const auto source = theirs.is_object() ? theirs.find("source") : theirs.end();
    reason = source == theirs.end() || *source == ours["source"]
                 ? "with other options"
                 : "of another volume, or of this one before it changed";
  } else {
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      // An interrupted start leaves no more than these two.
      if (name != "lock" && !name.starts_with("pack.json")) reason = "by another program";
    }
  }
  if (!reason.empty() && others == BegunByOthers::kReplace) {
    // The lock stays.
    for (const char* const part : {"store", "journal", "pack.json"}) {
      std::error_code status;
      fs::remove_all(folder_ / part, status);
      if (status)
        failSystem("{}: cannot be removed: {}", (folder_ / part).string(), status.message());
    }
  } else if (!reason.empty()) {
    failRequest(
        "{}: holds a store that was begun {}; give the volume and options of that run, or remove "
        "it to start again",
        folder_.string(), reason);
  }
  // Before the first chunk, so that chunks of unknown origin are never taken over.
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

bool ZarrPackFolder::checkChunk(int64_t chunk) const {
  const StoredChunk& noted = chunks_[static_cast<size_t>(chunk)];
  if (noted.bytes == 0) return true;
  try {
    File file(chunkPath(chunk));
    const uint64_t offset = hasShards() ? offsets_[static_cast<size_t>(chunk)] : 0;
    if (hasShards() ? file.sizeBytes() < offset + noted.bytes : file.sizeBytes() != noted.bytes)
      return false;
    std::vector<std::byte> bytes(noted.bytes);
    file.readAt(offset, bytes);
    if (!hasShards()) return zarrChecksum(bytes) == noted.checksum;
    const std::span content = std::span(bytes).first(noted.bytes - kShardCrcBytes);
    uint32_t crc = 0;
    std::memcpy(&crc, bytes.data() + content.size(), kShardCrcBytes);
    return zarrChecksum(content) == noted.checksum && crc32c(content) == crc;
  } catch (const Error&) {
    return false;  // to be written anew
  }
}

int64_t ZarrPackFolder::recover(WorkerPool& pool, ProgressMeter& progress, const StopToken& stop) {
  const std::vector<PackRecord> noted = journal_->recover(chunks_.size());
  for (const PackRecord& record : noted) {
    chunks_[record.chunk] = {record.bytes, record.checksum};
    if (!hasShards() || record.bytes == 0) continue;
    offsets_[record.chunk] = record.offset;
    uint64_t& end = ends_[shardOf(static_cast<int64_t>(record.chunk))];
    // Chunks that turn out to be damaged count, too: their place is not used again.
    end = std::max(end, record.offset + record.bytes);
  }
  std::atomic<int64_t> done = 0;
  pool.parallelFor(static_cast<int64_t>(noted.size()), [&](int64_t i) {
    stop.throwIfStopped();
    const auto chunk = static_cast<int64_t>(noted[static_cast<size_t>(i)].chunk);
    if (!checkChunk(chunk)) return;
    {
      const MutexLock lock(mutex_);
      // A chunk may be noted twice: if it was damaged after an earlier run, it was written again.
      if (std::exchange(done_[static_cast<size_t>(chunk)], 1) != 0) return;
    }
    ++done;
    progress.add(0);
  });
  return done;
}

}  // namespace sluice
