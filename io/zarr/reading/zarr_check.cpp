#include <algorithm>

#include "io/zarr/packing/zarr_writer.h"
#include "io/zarr/reading/zarr_source.h"
#include "src/base/error.h"
#include "src/base/threads/mutex.h"

namespace sluice {
namespace {

// Adds the findings on one array to `report`.
void checkArray(ZarrChunkFiles& files, CheckReport& report, WorkerPool& pool,
                ProgressMeter& progress, const StopToken& stop) {
  const std::vector<int64_t>& chunks = files.existing();
  for (const int64_t chunk : chunks) progress.expect(files.stored(chunk).bytes);
  Mutex mutex;
  pool.parallelFor(static_cast<int64_t>(chunks.size()), [&](int64_t i) {
    stop.throwIfStopped();
    const int64_t chunk = chunks[static_cast<size_t>(i)];
    std::string fault;
    uint64_t read = 0;
    try {
      std::vector<std::byte> bytes;
      files.read(chunk, [&](uint64_t count) {
        bytes.resize(count);
        return std::span(bytes);
      });
      read = bytes.size();
    } catch (const Error& error) {
      fault = error.what();
    }
    progress.add(files.stored(chunk).bytes);
    const MutexLock lock(mutex);
    report.stored_bytes += read;
    if (!fault.empty()) report.faults.push_back(fault);
  });
  report.chunks += static_cast<int64_t>(chunks.size());
  for (const int64_t chunk : files.onDisk())
    if (files.stored(chunk).bytes == 0)
      report.faults.push_back(
          fmt::format("{}: expected no such chunk, as packed, found one", files.path(chunk)));
}

}  // namespace

CheckReport checkZarr(const std::filesystem::path& folder, WorkerPool& pool,
                      ProgressMeter& progress, const StopToken& stop) {
  ZarrSource source(folder);
  if (!source.hasChecksums())
    fail("{}: has no checksums, as only sluice pack writes them; pack it to have some",
         folder.string());
  CheckReport report;
  checkArray(ZarrSource::filesOf(source), report, pool, progress, stop);
  // A level that is missing or does not fit is a fault, too.
  for (const std::string& note : source.layout().notes)
    if (note.find(" is left out: ") != std::string::npos) report.faults.push_back(note);
  const auto check = [&](VolumeSource& above) {
    ZarrChunkFiles& files = ZarrSource::filesOf(dynamic_cast<ChunkedSource&>(above));
    if (files.hasChecksums()) checkArray(files, report, pool, progress, stop);
  };
  for (const CoarserLevel& level : source.levelsAbove()) {
    check(*level.source);
    if (level.spreads != nullptr) check(*level.spreads);
  }
  std::sort(report.faults.begin(), report.faults.end());
  return report;
}

}  // namespace sluice
