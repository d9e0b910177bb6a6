#include "src/index/indexed_ranges.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include "src/base/files/byte_stream.h"
#include "src/index/brick_ranges_file.h"
#include "src/index/first_pass.h"
#include "src/index/index_file.h"
#include "src/index/slice_ranges_file.h"
#include "src/volume/passes/voxel_pass.h"

namespace sluice {
namespace {

// The version of the format in which learnt ranges are kept; the ranges have their own.
constexpr uint32_t kLearntVersion = 1;

std::string nameOf(const VolumeSource& source, int64_t time, const BlockLayout& layout) {
  // A volume of several levels has a ghost layer more, or two, and other arrays with it.
  return fmt::format("{}{}-{}", layout.size,
                     layout.ghost == 0   ? ""
                     : layout.ghost == 1 ? "-lit"
                     : layout.ghost == 2 ? "-levels"
                                         : "-odd-levels",
                     selectionOf(source.layout(), time));
}

IndexKey keyOf(const VolumeSource& source, int64_t time, const BlockLayout& layout) {
  return {source.identity(), "minmax-" + nameOf(source, time, layout),
          kSliceRangesVersion << 16 | kBrickRangesVersion};
}

IndexKey learntKeyOf(const VolumeSource& source, int64_t time, const BlockLayout& layout) {
  return {source.identity(), "learnt-" + nameOf(source, time, layout),
          kLearntVersion << 16 | kSliceRangesVersion};
}

// Both lie in one file, so that one is never newer than the other.
struct Kept {
  SliceRanges ranges;
  BrickRanges bricks;
};

// The ranges, the bricks, and how many bytes the bricks are.
std::vector<std::byte> bytesOf(const SliceRanges& ranges, const BrickRanges& bricks) {
  // The length of the bricks comes last, so that the ranges begin where their own reader expects
  // them.
  ByteWriter end;
  end.bytes = sluice::serialize(bricks);
  end.value<uint64_t>(end.bytes.size());
  std::vector<std::byte> bytes = sluice::serialize(ranges);
  bytes.insert(bytes.end(), end.bytes.begin(), end.bytes.end());
  return bytes;
}

std::optional<Kept> keptFrom(std::span<const std::byte> bytes, const BlockLayout& layout,
                             const ValueMap& map) {
  // The bytes may be anybody's: no length is believed before it is compared with what is there.
  uint64_t brick_bytes = 0;
  if (bytes.size() < sizeof brick_bytes) return std::nullopt;
  ByteReader(bytes.last(sizeof brick_bytes)).value(brick_bytes);
  bytes = bytes.first(bytes.size() - sizeof brick_bytes);
  if (brick_bytes > bytes.size()) return std::nullopt;
  auto bricks = deserializeBricks(bytes.last(brick_bytes), layout.dims, map.type);
  auto ranges = sluice::deserialize(bytes.first(bytes.size() - brick_bytes), layout, map);
  if (!ranges || !bricks) return std::nullopt;
  return Kept{*std::move(ranges), *std::move(bricks)};
}

void addNote(std::string& note, const std::string& more) {
  if (!note.empty() && !more.empty()) note += "; ";
  note += more;
}

// True: `result` has everything. False: it has a note at most, why an older index is not used.
bool readKept(const VolumeSource& source, const IndexPlaces& places, const IndexKey& key,
              const BlockLayout& layout, IndexedRanges& result) {
  IndexRead kept = readIndex(places, key);
  result.note = std::move(kept.note);
  if (!kept.blob) return false;
  std::optional<Kept> found = keptFrom(*kept.blob, layout, deviceMap(source.layout()));
  if (!found) {
    addNote(result.note, fmt::format("{}: of another volume, not used", kept.path.string()));
    return false;
  }
  result.ranges = std::move(found->ranges);
  result.bricks = std::move(found->bricks);
  result.path = result.ranges.index_file = std::move(kept.path);
  result.origin = IndexOrigin::kRead;
  return true;
}

}  // namespace

std::optional<IndexedRanges> keptRanges(const VolumeSource& source, const IndexPlaces& places,
                                        int64_t time, const BlockLayout& layout) {
  IndexedRanges result;
  if (!readKept(source, places, keyOf(source, time, layout), layout, result)) return std::nullopt;
  return result;
}

std::optional<IndexedRanges> keptRangesOfAnyBlocks(const VolumeSource& source,
                                                   const IndexPlaces& places, int64_t time) {
  // Indices of smaller blocks are longer than what they are read for is worth.
  constexpr int64_t kMostSide = 1024, kLeastSide = 16;
  constexpr int kMostGhosts = 3;
  // No index has the blocks of a sparse volume that 63 bits would not count.
  const Vec3d dims = toDouble(source.layout().dims);
  if (dims.x * dims.y * dims.z > 0x1p62) return std::nullopt;
  for (int64_t side = kMostSide; side >= kLeastSide; side /= 2)
    for (int ghost = 0; ghost <= kMostGhosts; ++ghost)
      if (auto kept =
              keptRanges(source, places, time, blockLayout(source.layout().dims, side, ghost)))
        return kept;
  return std::nullopt;
}

void keepLearnt(const VolumeSource& source, const IndexPlaces& places, int64_t time,
                const SliceRanges& ranges) {
  ByteWriter out;
  // The unknown blocks come first, since the ranges are read to their end.
  out.list(ranges.unknown);
  out.value<uint8_t>(ranges.is_listed ? 1 : 0);
  const std::vector<std::byte> bytes = sluice::serialize(ranges);
  out.bytes.insert(out.bytes.end(), bytes.begin(), bytes.end());
  writeIndex(places, learntKeyOf(source, time, ranges.layout), out.bytes);
}

std::optional<SliceRanges> keptLearnt(const VolumeSource& source, const IndexPlaces& places,
                                      int64_t time, const BlockLayout& layout) {
  const IndexRead kept = readIndex(places, learntKeyOf(source, time, layout));
  std::vector<int64_t> unknown;
  if (!kept.blob) return std::nullopt;
  ByteReader reader(*kept.blob);
  uint8_t is_listed = 0;
  if (!reader.list(unknown) || !reader.value(is_listed) || is_listed > 1) return std::nullopt;
  auto ranges = sluice::deserialize(reader.left(), layout, deviceMap(source.layout()));
  if (!ranges) return std::nullopt;
  // Each block is known or not, and the loops over blocks need ascending ids.
  const bool is_sound =
      std::ranges::is_sorted(unknown, std::less_equal<>()) &&
      (unknown.empty() || (unknown.front() >= 0 && unknown.back() < layout.blockCount())) &&
      std::ranges::none_of(ranges->blocks, [&](int64_t block) {
        return std::ranges::binary_search(unknown, block);
      });
  if (!is_sound) return std::nullopt;
  // Without a listing no block is background: each is unknown or held.
  if (is_listed == 0 &&
      static_cast<int64_t>(unknown.size() + ranges->blocks.size()) != layout.blockCount())
    return std::nullopt;
  ranges->unknown = std::move(unknown);
  ranges->is_listed = is_listed == 1;
  ranges->index_file = kept.path;
  return ranges;
}

IndexedRanges indexedRanges(VolumeSource& source, const IndexPlaces& places, int64_t time,
                            const BlockLayout& layout, const VolumePass& pass, VoxelTaker* taker) {
  const IndexKey key = keyOf(source, time, layout);
  IndexedRanges result;
  const bool is_kept = readKept(source, places, key, layout, result);
  // A taker wants to see all voxels, also if the ranges are there.
  if (is_kept && taker == nullptr) return result;
  WorkerPool& pool = pass.pool;
  // A thread that waits for files leaves its processor idle, so that such sources have several for
  // each.
  const int each = pool.threads() > 1 ? source.passReads().threads_each : 1;
  // The plan reads the source's listing, which may take long: it is made only if a pass follows.
  const FirstPass plan =
      planFirstPass(source, time, layout, pass.memory_bytes,
                    std::max(each * pool.threads(), source.distantReads()), pass.budgets);
  std::optional<WorkerPool> other;
  // Memory may allow fewer threads than the pool has, and slow sources want more.
  if (plan.threads != pool.threads()) other.emplace(plan.threads);
  const VolumePass first{other ? *other : pool, pass.progress, plan.voxel_bytes, pass.stop};
  if (is_kept) {
    passVoxels(source, time, layout, first, *taker);
    return result;
  }
  result.ranges = buildSliceRanges(source, time, layout, first, result.bricks, taker);
  // An index that cannot be kept is no failure: the next opening makes it anew.
  IndexWritten written = writeIndex(places, key, bytesOf(result.ranges, result.bricks));
  result.path = std::move(written.path);
  result.origin = builtOrigin(result.path);
  addNote(result.note, written.note);
  return result;
}

}  // namespace sluice
