#include "io/zarr/packing/level_packer.h"

#include <fmt/format.h>

#include <utility>

#include "io/zarr/metadata/zarr_image.h"

namespace sluice {
namespace {

// Level 0's array for another level.
ZarrArray arrayOf(const ZarrArray& finest, const LevelShape& level) {
  ZarrArray array = finest;
  for (int a = 0; a < 3; ++a)
    array.shape[array.axes() - 1 - static_cast<size_t>(a)] = level.dims[a];
  return array;
}

// The same for the spreads of a level.
ZarrArray spreadsOf(ZarrArray array) {
  array.type = spreadType(array.type);
  array.fill_value = 0;
  return array;
}

}  // namespace

std::vector<PackedArray> levelArrays(const ZarrArray& finest, std::span<const LevelShape> levels,
                                     Downsample how, int64_t first, std::string_view group) {
  std::vector<PackedArray> arrays;
  for (const LevelShape& level : levels)
    arrays.push_back({fmt::format("{}{}{}", group, group.empty() ? "" : "/",
                                  first + static_cast<int64_t>(arrays.size())),
                      arrayOf(finest, level)});
  if (keepsSpreads(how))
    for (size_t i = 0; i < levels.size(); ++i)
      arrays.push_back(
          {fmt::format("{}/{}", kZarrSpreadFolder, arrays[i].folder), spreadsOf(arrays[i].array)});
  return arrays;
}

LevelPacker::LevelPacker(const VolumeLayout& layout, int64_t chunk_voxels,
                         std::vector<LevelShape> levels, Downsample how,
                         std::span<const std::byte> fill, size_t first, ChunkPacker& packer,
                         WorkerPool& pool)
    : planes_(layout.dims.z),
      chunk_voxels_(chunk_voxels),
      has_spreads_(keepsSpreads(how)),
      first_(first),
      packer_(packer),
      pool_(pool),
      maker_(layout, chunk_voxels, std::move(levels), how, fill) {}

std::vector<Vec3i> LevelPacker::missingOf(const ZarrPackFolder& folder, size_t array,
                                          std::span<const int64_t> leading,
                                          const Box3& layer) const {
  std::vector<Vec3i> missing;
  for (const Vec3i chunk : packer_.chunksOf(layer))
    if (!folder.isDone(packer_.numberOf(folder, first_ + array, leading, chunk)))
      missing.push_back(chunk);
  return missing;
}

bool LevelPacker::isLayerWanted(const ZarrPackFolder& folder, std::span<const int64_t> leading,
                                int64_t z) const {
  for (size_t array = 0; array < arrays(); ++array)
    if (!missingOf(folder, array, leading, maker_.layerAt(levelOf(array), z)).empty()) return true;
  return false;
}

void LevelPacker::packLayers(ZarrPackFolder& folder, std::span<const int64_t> leading, int64_t end,
                             const StopToken& stop) {
  const auto isEnd = [&](size_t level) {
    // A level's layer of chunks ends where the finest layer that it is made of does.
    return end % (levels()[level].step.z * chunk_voxels_) == 0 || end == planes_;
  };
  for (size_t level = 0; level < levels().size(); ++level)
    if (isEnd(level)) maker_.endLayer(level);
  for (size_t array = 0; array < arrays(); ++array) {
    const size_t level = levelOf(array);
    if (!isEnd(level)) continue;
    const HeldVoxels held{maker_.layerAt(level, end - 1), isSpreads(array)
                                                              ? maker_.layerSpreads(level)
                                                              : maker_.layerVoxels(level)};
    // Chunks that an earlier run has written are left as they are.
    const std::vector<Vec3i> chunks = missingOf(folder, array, leading, held.box);
    pool_.parallelFor(static_cast<int64_t>(chunks.size()), [&](int64_t c) {
      stop.throwIfStopped();
      const Vec3i chunk = chunks[static_cast<size_t>(c)];
      packer_.pack(folder, first_ + array, packer_.numberOf(folder, first_ + array, leading, chunk),
                   held, chunk);
    });
  }
}

}  // namespace sluice
