#include "src/index/indexed_ranges.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "src/index/first_pass.h"
#include "src/index/index_file.h"
#include "src/index/slice_ranges_file.h"

namespace sluice {
namespace {

IndexKey keyOf(const VolumeSource& source, int64_t time, const BlockLayout& layout) {
  return {source.identity(),
          fmt::format("minmax-{}{}-{}", layout.size,
                      layout.ghost == 0   ? ""
                      : layout.ghost == 1 ? "-lit"
                                          : "-levels",
                      selectionOf(source.layout(), time)),
          kSliceRangesVersion};
}

void addNote(std::string& note, const std::string& more) {
  if (!note.empty() && !more.empty()) note += "; ";
  note += more;
}

}  // namespace

IndexedRanges indexedRanges(VolumeSource& source, const IndexPlaces& places, int64_t time,
                            const BlockLayout& layout, WorkerPool& pool, ProgressMeter& progress,
                            uint64_t memory_bytes, const StopToken& stop) {
  const IndexKey key = keyOf(source, time, layout);
  IndexedRanges result;
  IndexRead kept = readIndex(places, key);
  result.note = std::move(kept.note);
  if (kept.blob) {
    std::optional<SliceRanges> ranges = deserialize(*kept.blob, layout, deviceMap(source.layout()));
    if (ranges) {
      result.ranges = std::move(*ranges);
      result.path = result.ranges.index_file = std::move(kept.path);
      result.state = "read";
      return result;
    }
    addNote(result.note, fmt::format("{}: of another volume, not used", kept.path.string()));
  }
  const FirstPass pass = planFirstPass(source, time, layout, memory_bytes, pool.threads());
  std::optional<WorkerPool> fewer;
  if (pass.threads < pool.threads()) fewer.emplace(pass.threads);
  result.ranges = buildSliceRanges(source, time, layout, fewer ? *fewer : pool, progress,
                                   pass.voxel_bytes, stop);
  IndexWritten written = writeIndex(places, key, serialize(result.ranges));
  result.path = std::move(written.path);
  result.state = result.path.empty() ? "built, not kept" : "built";
  addNote(result.note, written.note);
  return result;
}

}  // namespace sluice
