#include "io/zarr/packing/zarr_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

#include "io/zarr/packing/chunk_packer.h"
#include "io/zarr/packing/free_name.h"
#include "io/zarr/packing/level_packer.h"
#include "io/zarr/packing/store_texts.h"
#include "io/zarr/packing/zarr_pack_folder.h"
#include "io/zarr/reading/zarr_source.h"
#include "src/base/error.h"
#include "src/base/memory/aligned_array.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

// Makes the array one of shards, whose files are boxes of so many voxels.
void setShards(Vec3i voxels, ZarrArray& array) {
  int64_t chunks = 1;
  for (int a = 0; a < 3; ++a) {
    const size_t axis = array.axes() - 1 - static_cast<size_t>(a);
    const int64_t side = array.chunks[axis];
    if (voxels[a] < side || voxels[a] % side != 0 || voxels[a] / side > kMostChunksAFile)
      failRequest("--shard {},{},{}: expected multiples of the chunks' {} voxels", voxels.x,
                  voxels.y, voxels.z, side);
    array.files[axis] = voxels[a];
    chunks *= voxels[a] / side;
    if (chunks > kMostChunksAFile)
      failRequest("--shard {},{},{}: more than {} chunks of {} voxels a side", voxels.x, voxels.y,
                  voxels.z, kMostChunksAFile, side);
  }
  array.prefix = "c";
  array.has_crc = true;
  array.shards = ZarrShardIndex{.has_crc = true, .byte_order = std::endian::native};
}

ZarrArray arrayFor(ChannelSources channels, const PackOptions& options) {
  VolumeSource& source = *channels.front();
  const VolumeLayout& layout = source.layout();
  std::vector<int64_t> leading;
  for (const int64_t count : {layout.time_steps, static_cast<int64_t>(channels.size())})
    if (count > 1) leading.push_back(count);
  const std::optional<Occupancy> occupancy = source.occupancy(0);
  const bool is_known = occupancy && std::isfinite(occupancy->background);
  ZarrArray array =
      packedArray(layout, leading, options.chunk_voxels, is_known ? occupancy->background : 0);
  if (options.shard_voxels) setShards(*options.shard_voxels, array);
  return array;
}

// Limit for the source of the channel that is read.
constexpr uint64_t kMostHeldBytes = uint64_t{32} << 20;

std::vector<LevelShape> levelsFor(const VolumeLayout& layout, const PackOptions& options) {
  if (!options.with_levels) return {};
  std::vector<LevelShape> levels = levelShapes(layout, options.chunk_voxels, options.levels);
  if (options.levels && static_cast<int64_t>(levels.size()) < *options.levels)
    failRequest("--levels {}: {} x {} x {} voxels in chunks of {} have {} coarser levels at most",
                *options.levels, layout.dims.x, layout.dims.y, layout.dims.z, options.chunk_voxels,
                levels.size());
  return levels;
}

// The arrays of the store: level 0, and for each way to make coarser levels these, with their
// spreads if they have some.
struct StoreArrays {
  std::vector<PackedArray> arrays{};
  std::vector<size_t> first;  // for each way, the first of its levels
};
StoreArrays arraysFor(const ZarrArray& finest, const std::vector<LevelShape>& levels,
                      const std::vector<Downsample>& ways) {
  StoreArrays store;
  store.arrays.push_back({"0", finest});
  for (const Downsample how : ways) {
    const bool is_main = store.first.empty();
    store.first.push_back(store.arrays.size());
    const std::string_view group = is_main ? "" : zarrLevelsFolder(valuesOf(how));
    for (PackedArray& array : levelArrays(finest, levels, how, 1, group))
      store.arrays.push_back(std::move(array));
  }
  return store;
}

// One volume of a store: a time step of a channel.
struct StoreVolume {
  int64_t time = 0;
  size_t channel = 0;
};

class Packer {
 public:
  // `store`: arraysFor() of `levels`.
  Packer(ChannelSources channels, const PackOptions& options, const StoreArrays& store,
         const std::vector<LevelShape>& levels, WorkerPool& pool, ProgressMeter& progress)
      : channels_(channels),
        layout_(channels.front()->layout()),
        options_(options),
        arrays_(store.arrays),
        array_(arrays_.front().array),
        pool_(pool),
        progress_(progress),
        voxel_(static_cast<int64_t>(bytesPerVoxel(array_.type))),
        chunks_(arrays_, options.chunk_voxels, options.blosc) {
    planSlabs(levels);
    for (size_t i = 0; i < store.first.size(); ++i)
      levels_.push_back(std::make_unique<LevelPacker>(layout_, options.chunk_voxels, levels,
                                                      options.downsample[i], fillVoxel(array_),
                                                      store.first[i], chunks_, pool));
  }

  void pack(ZarrPackFolder& folder) {
    eachSlab([&](StoreVolume of, const Box3& slab, bool known_empty) {
      const auto bytes = static_cast<uint64_t>(slab.count() * voxel_);
      const std::vector<Vec3i> chunks = chunks_.chunksOf(slab);
      const std::vector<int64_t> leading = leadingIndex(of);
      const auto numberOf = [&](Vec3i chunk) {
        return chunks_.numberOf(folder, 0, leading, chunk);
      };
      const bool is_done = std::all_of(chunks.begin(), chunks.end(),
                                       [&](Vec3i chunk) { return folder.isDone(numberOf(chunk)); });
      // Coarser levels are made from level 0's voxels, so that these may be read although their
      // chunks are done.
      const bool makes_levels =
          !known_empty && std::ranges::any_of(levels_, [&](const auto& levels) {
            return levels->isLayerWanted(folder, leading, slab.lo.z);
          });
      if ((!is_done && !known_empty) || makes_levels) read(of, slab, slab_.get());
      if (!is_done || makes_levels)
        pool_.parallelFor(static_cast<int64_t>(chunks.size()), [&](int64_t i) {
          options_.stop.throwIfStopped();
          const Vec3i chunk = chunks[static_cast<size_t>(i)];
          if (makes_levels) addToLevels(slab, chunk);
          const int64_t number = numberOf(chunk);
          if (folder.isDone(number)) return;
          if (known_empty)
            chunks_.packEmpty(folder, number);
          else
            chunks_.pack(folder, 0, number, {slab, slab_.get()}, chunk);
        });
      const bool ends_layer = slab.hi.x == layout_.dims.x && slab.hi.y == layout_.dims.y;
      if (ends_layer)
        for (const auto& levels : levels_)
          levels->packLayers(folder, leading, slab.hi.z, options_.stop);
      progress_.add(bytes);
    });
  }

  // Against the store as anybody reads it.
  void verify(const std::filesystem::path& store) {
    std::vector<std::unique_ptr<ZarrSource>> packed;
    for (size_t c = 0; c < channels_.size(); ++c) {
      ZarrOptions reading{.chunk_cache_bytes = 0};
      if (channels_.size() > 1) reading.channel = static_cast<int64_t>(c);
      packed.push_back(std::make_unique<ZarrSource>(store, reading));
    }
    eachSlab([&](StoreVolume of, const Box3& slab, bool) {
      read(of, slab, slab_.get());
      const Vec3i size = slab.size();
      const std::vector<Vec3i> chunks = chunks_.chunksOf(slab);
      pool_.parallelFor(static_cast<int64_t>(chunks.size()), [&](int64_t i) {
        options_.stop.throwIfStopped();
        const Box3 box = intersect(chunks_.boxOf(chunks[static_cast<size_t>(i)]), slab);
        const ChunkPacker::Lease scratch(chunks_);
        const auto bytes =
            std::span(scratch->chunk).first(static_cast<size_t>(box.count() * voxel_));
        packed[of.channel]->readRegion(of.time, box, bytes);
        const std::byte* row = bytes.data();
        for (int64_t z = box.lo.z; z < box.hi.z; ++z)
          for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
            const int64_t at =
                ((z - slab.lo.z) * size.y + y - slab.lo.y) * size.x + box.lo.x - slab.lo.x;
            const auto row_bytes = static_cast<size_t>(box.size().x * voxel_);
            if (std::memcmp(row, slab_.get() + at * voxel_, row_bytes) != 0)
              fail("{}: chunk {} differs from the volume in row y {}, z {}, time step {}",
                   store.string(),
                   array_.fileName(
                       array_.placeOf(numberInArray(of, chunks[static_cast<size_t>(i)])).file),
                   y, z, of.time);
            row += row_bytes;
          }
      });
      progress_.add(static_cast<uint64_t>(slab.count() * voxel_));
    });
  }

 private:
  // The largest slab that the memory has room for: whole planes of chunks, or rows of one plane, or
  // a part of one row, and one chunk thick.
  void planSlabs(const std::vector<LevelShape>& levels) {
    const Vec3i dims = layout_.dims;
    const int64_t side = options_.chunk_voxels;
    uint64_t table = 0;
    for (const PackedArray& packed : arrays_) table += ZarrPackFolder::tableBytes(packed.array);
    const uint64_t chunk = array_.chunkBytes();
    uint64_t pending = 0, making = 0;
    for (const Downsample how : options_.downsample) {
      pending += LevelMaker::pendingBytes(layout_, side, levels, how);
      making += levels.empty() ? 0 : LevelMaker::threadBytes(layout_, side);
    }
    // To verify, each thread holds two chunks inside the reader, which is less than packing takes.
    const uint64_t fixed =
        table + pending +
        static_cast<uint64_t>(pool_.threads()) * (ChunkPacker::threadBytes(chunk) + making);
    if (options_.memory_bytes < fixed + chunk)
      failMemory(
          "--memory {}: too small to pack with {} threads and chunks of {}{}; give --memory {} or "
          "more{}",
          options_.memory_bytes, pool_.threads(), formatBytes(chunk),
          levels.empty() ? "" : fmt::format(", and {} of coarser levels", formatBytes(pending)),
          fixed + chunk, levels.empty() ? "" : ", or --levels none");
    const auto rest = static_cast<int64_t>(std::min<uint64_t>(
        (options_.memory_bytes - fixed) / static_cast<uint64_t>(voxel_), uint64_t{1} << 60));
    slab_voxels_ = min(dims, Vec3i{dims.x, dims.y, side});
    if (volume(slab_voxels_) > rest) {
      const int64_t row = dims.x * std::min(side, dims.y) * slab_voxels_.z;
      slab_voxels_.y = std::min(dims.y, std::max<int64_t>(1, rest / row) * side);
      if (row > rest) {
        const Vec3i one = min(dims, Vec3i{side, side, side});
        slab_voxels_.x = std::min(dims.x, std::max<int64_t>(1, rest / volume(one)) * side);
      }
    }
    slab_bytes_ = static_cast<size_t>(volume(slab_voxels_) * voxel_);
    slab_ = alignedForOverwrite<std::byte>(slab_bytes_);
  }

  template <class F>
  void eachSlab(F&& f) {
    const Vec3i step = slab_voxels_;
    for (int64_t t = 0; t < layout_.time_steps; ++t)
      for (size_t c = 0; c < channels_.size(); ++c) {
        VolumeSource& source = takeUp(c);
        const std::optional<Occupancy> occupancy = source.occupancy(t);
        const bool fill_is_background = occupancy && occupancy->background == array_.fill_value;
        for (int64_t z = 0; z < layout_.dims.z; z += step.z)
          for (int64_t y = 0; y < layout_.dims.y; y += step.y)
            for (int64_t x = 0; x < layout_.dims.x; x += step.x) {
              options_.stop.throwIfStopped();
              const Vec3i lo{x, y, z};
              const Box3 slab = intersect({lo, lo + step}, boxOf(layout_.dims));
              f(StoreVolume{t, c}, slab,
                fill_is_background &&
                    std::none_of(occupancy->boxes.begin(), occupancy->boxes.end(),
                                 [&](const Box3& b) { return !intersect(b, slab).empty(); }));
            }
      }
  }

  // The channel's source. Only one of several keeps decoded voxels at a time.
  VolumeSource& takeUp(size_t channel) {
    if (channels_.size() > 1) {
      for (VolumeSource* source : channels_) source->holdAtMost(0);
      channels_[channel]->holdAtMost(kMostHeldBytes);
    }
    return *channels_[channel];
  }

  // The index of the arrays' chunks along the axes before z.
  std::vector<int64_t> leadingIndex(StoreVolume of) const {
    std::vector<int64_t> index;
    if (layout_.time_steps > 1) index.push_back(of.time);
    if (channels_.size() > 1) index.push_back(static_cast<int64_t>(of.channel));
    return index;
  }
  // The number of a chunk within level 0's array.
  int64_t numberInArray(StoreVolume of, Vec3i chunk) const {
    std::vector<int64_t> index = leadingIndex(of);
    for (int a = 2; a >= 0; --a) index.push_back(chunk[a]);
    return array_.chunkNumber(index);
  }

  void addToLevels(const Box3& slab, Vec3i chunk) {
    const Box3 box = intersect(chunks_.boxOf(chunk), slab);
    const Vec3i size = slab.size(), at = box.lo - slab.lo;
    const std::byte* const voxels = slab_.get() + ((at.z * size.y + at.y) * size.x + at.x) * voxel_;
    for (const auto& levels : levels_) levels->add(box, voxels, size.x, size.x * size.y);
  }

  // All threads at work on planes of the slab: each plane of a file is read by one of them, once.
  void read(StoreVolume of, const Box3& slab, std::byte* out) {
    const int64_t planes = slab.size().z;
    // Twice as many pieces as threads, so that none waits long for the last one.
    const int64_t pieces = std::min<int64_t>(planes, 2 * pool_.threads());
    const int64_t plane_bytes = slab.size().x * slab.size().y * voxel_;
    pool_.parallelFor(pieces, [&](int64_t i) {
      options_.stop.throwIfStopped();
      const int64_t first = planes * i / pieces, end = planes * (i + 1) / pieces;
      Box3 piece = slab;
      piece.lo.z = slab.lo.z + first;
      piece.hi.z = slab.lo.z + end;
      channels_[of.channel]->readRegion(
          of.time, piece,
          {out + first * plane_bytes, static_cast<size_t>((end - first) * plane_bytes)});
    });
  }

  const ChannelSources channels_;
  const VolumeLayout& layout_;  // layout of each channel
  const PackOptions& options_;
  const std::vector<PackedArray>& arrays_;  // of the store
  const ZarrArray& array_;                  // of level 0
  WorkerPool& pool_;
  ProgressMeter& progress_;
  const int64_t voxel_;
  ChunkPacker chunks_;
  Vec3i slab_voxels_;
  size_t slab_bytes_ = 0;
  AlignedArray<std::byte> slab_;
  std::vector<std::unique_ptr<LevelPacker>> levels_;  // one for each way to make them
};

}  // namespace

PackReport packZarr(VolumeSource& source, const std::filesystem::path& output,
                    const PackOptions& options, WorkerPool& pool, ProgressMeter& progress) {
  VolumeSource* const one = &source;
  return packZarr(std::span(&one, 1), output, options, pool, progress);
}

PackReport packZarr(ChannelSources channels, const std::filesystem::path& output,
                    const PackOptions& options, WorkerPool& pool, ProgressMeter& progress) {
  requireFreeName(output, options.replace);
  const uint64_t voxel_bytes = packedBytes(channels);
  const std::vector<LevelShape> levels = levelsFor(channels.front()->layout(), options);
  const StoreArrays made = arraysFor(arrayFor(channels, options), levels, options.downsample);
  const std::vector<PackedArray>& arrays = made.arrays;
  const StoreTexts texts = storeTexts(channels, options, arrays, levels);
  Packer packer(channels, options, made, levels, pool, progress);

  const Stopwatch watch;
  ZarrPackFolder folder(output, arrays, channels.front()->identity(), texts.parameters());
  PackReport report;
  report.kept_chunks = folder.recover(pool, progress, options.stop);
  packer.pack(folder);
  const std::filesystem::path store = folder.complete(texts.group, texts.image, texts.arrays);
  report.pack_seconds = watch.seconds();
  // Before the store has its name, so that a store of that name was compared.
  if (options.verify) packer.verify(store);
  report.verify_seconds = watch.seconds() - report.pack_seconds;

  report.chunks = static_cast<int64_t>(folder.chunks().size());
  report.files = folder.chunkFiles();
  for (const LevelShape& level : levels) report.levels.push_back(level.dims);
  for (const StoredChunk& chunk : folder.chunks()) {
    report.stored_bytes += chunk.bytes;
    report.empty_chunks += chunk.bytes == 0 ? 1 : 0;
  }
  report.voxel_bytes = voxel_bytes;
  folder.finish({.replace = options.replace});
  report.pack_seconds = watch.seconds() - report.verify_seconds;
  return report;
}

}  // namespace sluice
