#include <algorithm>
#include <optional>

#include "io/zarr/packing/zarr_writer.h"
#include "io/zarr/reading/zarr_source.h"
#include "src/base/error.h"
#include "src/base/threads/mutex.h"

namespace sluice {
namespace {

// The number in the array of a chunk of a file; nullopt: it lies beyond the array.
std::optional<int64_t> chunkOfFile(const ZarrArray& array, int64_t file, int64_t chunk) {
  std::vector<int64_t> index = array.fileIndex(file);
  for (size_t a = array.axes(); a-- > 0;) {
    const int64_t along = array.files[a] / array.chunks[a];
    index[a] = index[a] * along + chunk % along;
    chunk /= along;
    if (index[a] >= ceilDiv(array.shape[a], array.chunks[a])) return std::nullopt;
  }
  return array.chunkNumber(index);
}

// Adds the findings on one array to `report`.
void checkArray(ZarrChunkFiles& files, CheckReport& report, WorkerPool& pool,
                ProgressMeter& progress, const StopToken& stop) {
  const bool is_listed = files.hasChecksums();
  const ZarrArray& array = files.array();
  // Chunks are gone through file by file, so that a store of few files takes little memory however
  // many chunks its metadata tell of. Only the indices of shards know which of them are there, and
  // reading one may fail.
  const std::vector<int64_t>& there = files.existing();
  const int64_t each = array.chunksAFile();
  const auto bytesOf = [&](int64_t chunk) {
    return is_listed ? files.stored(chunk).bytes : array.chunkBytes();
  };
  for (const int64_t file : there)
    progress.expect(is_listed ? bytesOf(file) : static_cast<uint64_t>(each) * array.chunkBytes());
  int64_t found = 0;
  Mutex mutex;
  pool.parallelFor(static_cast<int64_t>(there.size()) * each, [&](int64_t i) {
    stop.throwIfStopped();
    const std::optional<int64_t> inside =
        chunkOfFile(array, there[static_cast<size_t>(i / each)], i % each);
    // A shard at an upper end of the array has room for chunks beyond it.
    if (!inside) return progress.add(array.chunkBytes());
    const int64_t chunk = *inside;
    std::string fault;
    uint64_t read = 0;
    try {
      std::vector<std::byte> bytes;
      const auto room = [&](uint64_t count) {
        bytes.resize(count);
        return std::span(bytes);
      };
      if (files.exists(chunk)) files.read(chunk, room);
      read = bytes.size();
    } catch (const Error& error) {
      fault = error.what();
    }
    progress.add(bytesOf(chunk));
    const MutexLock lock(mutex);
    report.stored_bytes += read;
    if (read > 0 || !fault.empty()) ++found;
    if (!fault.empty()) report.faults.push_back(fault);
  });
  report.chunks += found;
  if (!is_listed) return;
  // A chunk that was not packed has been added since.
  for (const int64_t chunk : files.onDisk())
    if (files.stored(chunk).bytes == 0)
      report.faults.push_back(
          fmt::format("{}: expected no such chunk, as packed, found one", files.path(chunk)));
}

}  // namespace

CheckReport checkZarr(const std::filesystem::path& folder, WorkerPool& pool,
                      ProgressMeter& progress, const StopToken& stop) {
  ZarrSource source(folder);
  const auto hasSome = [](const ZarrChunkFiles& files) {
    return files.hasChecksums() || files.array().has_crc;
  };
  if (!hasSome(ZarrSource::filesOf(source)))
    fail("{}: has no checksums, as sluice pack writes them; pack it to have some", folder.string());
  CheckReport report;
  checkArray(ZarrSource::filesOf(source), report, pool, progress, stop);
  // A level that is missing or does not fit is a fault, too.
  for (const std::string& note : source.layout().notes)
    if (note.find(" is left out: ") != std::string::npos) report.faults.push_back(note);
  const auto check = [&](VolumeSource& above) {
    ZarrChunkFiles& files = ZarrSource::filesOf(dynamic_cast<ChunkedSource&>(above));
    if (hasSome(files)) checkArray(files, report, pool, progress, stop);
  };
  const auto checkLevels = [&](std::span<const CoarserLevel> levels) {
    for (const CoarserLevel& level : levels) {
      check(*level.source);
      if (level.spreads != nullptr) check(*level.spreads);
    }
  };
  checkLevels(source.levelsAbove());
  for (const LevelValues values : kLevelKinds) checkLevels(source.levelsOfKind(values));
  std::sort(report.faults.begin(), report.faults.end());
  // A damaged index is a fault of each of its shard's chunks.
  report.faults.erase(std::unique(report.faults.begin(), report.faults.end()), report.faults.end());
  return report;
}

}  // namespace sluice
