#include "io/zarr/packing/level_store.h"

#include <cmath>
#include <utility>

#include "io/files/file.h"
#include "io/zarr/metadata/zarr_text.h"
#include "io/zarr/packing/free_name.h"
#include "src/base/error.h"
#include "src/base/values/digest.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Levels are made and read much faster than files are packed for keeping.
constexpr BloscOptions kBlosc{.codec = BloscCodec::kLz4, .level = 1, .shuffles_bits = false};

double fillValueOf(VolumeSource& source, int64_t time) {
  const std::optional<Occupancy> occupancy = source.occupancy(time);
  return occupancy ? occupancy->background : 0;
}

std::vector<PackedArray> arraysOf(const VolumeLayout& layout, const LevelStorePlan& plan,
                                  double fill_value) {
  const ZarrArray finest = packedArray(layout, {}, plan.chunk_voxels, fill_value);
  return levelArrays(finest, plan.levels, plan.how, 0);
}

// The volume's first coarser level as a volume of its own.
VolumeLayout firstLevel(VolumeLayout layout, const LevelShape& shape) {
  const LevelPlacement place = placementOf(shape);
  for (int a = 0; a < 3; ++a)
    layout.origin =
        layout.origin + layout.axes[static_cast<size_t>(a)] * (layout.spacing[a] * place.offset[a]);
  layout.spacing = layout.spacing * place.scale;
  layout.dims = shape.dims;
  layout.time_steps = 1;
  return layout;
}

std::string imageText(const VolumeLayout& layout, const LevelStorePlan& plan) {
  const std::vector<LevelShape>& levels = plan.levels;
  const LevelPlacement first = placementOf(levels.front());
  ZarrLevelsText text{{}, valuesOf(plan.how), keepsSpreads(plan.how)};
  for (size_t i = 1; i < levels.size(); ++i) {
    const LevelPlacement place = placementOf(levels[i]);
    text.placements.push_back(
        {place.scale / first.scale, (place.offset - first.offset) / first.scale});
  }
  return zarrImageText(firstLevel(layout, levels.front()), layout.name, {}, text);
}

}  // namespace

std::optional<LevelStorePlan> planLevelStore(const VolumeLayout& layout, Downsample how,
                                             uint64_t memory_bytes, int threads) {
  const int numbers = keepsSpreads(how) ? 2 : 1;
  // Smaller chunks hold less while a level is made.
  for (const int64_t side : {64, 32, 16}) {
    LevelStorePlan plan{how, levelShapes(layout, side, std::nullopt), side, 0, 0};
    double voxels = 0, chunks = 0;
    for (const LevelShape& level : plan.levels) {
      const Vec3d dims = toDouble(level.dims);
      voxels += dims.x * dims.y * dims.z;
      const Vec3d grid = toDouble(Vec3i{ceilDiv(level.dims.x, side), ceilDiv(level.dims.y, side),
                                        ceilDiv(level.dims.z, side)});
      chunks += numbers * grid.x * grid.y * grid.z;
    }
    const double voxel_bytes =
        voxels * static_cast<double>(storedBytesPerVoxel(layout.type, numbers));
    const auto chunk_bytes = static_cast<uint64_t>(side * side * side) * bytesPerVoxel(layout.type);
    const double table = chunks * (sizeof(StoredChunk) + 1);
    if (voxel_bytes + table > 1e18) return std::nullopt;
    plan.voxel_bytes = static_cast<uint64_t>(voxel_bytes);
    plan.held_bytes =
        static_cast<uint64_t>(table) + LevelMaker::pendingBytes(layout, side, plan.levels, how) +
        static_cast<uint64_t>(threads) *
            (ChunkPacker::threadBytes(chunk_bytes) + LevelMaker::threadBytes(layout, side));
    if (plan.held_bytes <= memory_bytes) return plan;
  }
  return std::nullopt;
}

bool canMakeLevels(VolumeSource& source, int64_t time) {
  return std::isfinite(fillValueOf(source, time));
}

LevelStoreWriter::LevelStoreWriter(VolumeSource& source, int64_t time, const fs::path& output,
                                   const LevelStorePlan& plan, WorkerPool& pool,
                                   const StopToken& stop)
    : plan_(plan),
      layout_(source.layout()),
      stop_(stop),
      arrays_(arraysOf(layout_, plan_, fillValueOf(source, time))),
      image_text_(imageText(layout_, plan_)),
      chunks_(arrays_, plan_.chunk_voxels, kBlosc),
      levels_(layout_, plan_.chunk_voxels, plan_.levels, plan_.how,
              fillVoxel(arrays_.front().array), 0, chunks_, pool) {
  requireFreeName(output, true);
  std::string parameters = image_text_;
  for (const PackedArray& packed : arrays_) {
    array_texts_.push_back(zarrArrayTexts(packed.array, kBlosc));
    parameters += array_texts_.back().header;
  }
  folder_ = std::make_unique<ZarrPackFolder>(
      output, arrays_, fmt::format("{}, time step {}", source.identity(), time), parameters,
      BegunByOthers::kReplace);
  ProgressMeter unwatched;
  folder_->recover(pool, unwatched, stop);
}

bool LevelStoreWriter::wantsLayer(int64_t z) {
  is_wanted_ = fault_.empty() && levels_.isLayerWanted(*folder_, {}, z);
  return is_wanted_;
}

void LevelStoreWriter::take(const VoxelPiece& piece) {
  if (!is_wanted_) return;
  const auto voxel = static_cast<int64_t>(bytesPerVoxel(layout_.type));
  const int64_t columns = levels_.longestRow();
  for (int64_t x = piece.box.lo.x; x < piece.box.hi.x; x += columns) {
    Box3 cube = piece.box;
    cube.lo.x = x;
    cube.hi.x = std::min(x + columns, piece.box.hi.x);
    levels_.add(cube, piece.voxels + (x - piece.box.lo.x) * voxel, piece.row_stride,
                piece.plane_stride);
  }
}

void LevelStoreWriter::layersBefore(int64_t end) {
  if (!fault_.empty()) return;
  try {
    levels_.packLayers(*folder_, {}, end, stop_);
    // Levels are a convenience: a full disk must not end the pass that makes the index.
  } catch (const Error& error) {
    fault_ = error.what();
  }
}

bool LevelStoreWriter::finish() {
  if (!fault_.empty()) return false;
  try {
    folder_->complete(zarrGroupText(), image_text_, array_texts_);
    // The file is not synced: the digest in the index file finds damage by a power cut.
    folder_->finish({.replace = true, .sync = false});
  } catch (const Error& error) {
    fault_ = error.what();
  }
  return fault_.empty();
}

LevelStore::LevelStore(const fs::path& folder, const VolumeLayout& finest, Downsample how)
    : source_(std::make_unique<ZarrSource>(folder, ZarrOptions())) {
  const Vec3i chunk = source_->chunkVoxels();
  const std::vector<LevelShape> shapes = levelShapes(finest, chunk.x, std::nullopt);
  // The store's own finest level is the volume's first coarser one.
  std::vector<CoarserLevel> found{{source_.get(), {}, source_->spreads()}};
  for (const CoarserLevel& level : source_->levelsAbove()) found.push_back(level);
  const std::vector<std::string>& notes = source_->layout().notes;
  if (found.size() != shapes.size())
    fail("{}: expected {} levels, found {}{}", folder.string(), shapes.size(), found.size(),
         notes.empty() ? "" : ": " + notes.front());
  for (size_t i = 0; i < shapes.size(); ++i) {
    const VolumeLayout& level = found[i].source->layout();
    if ((found[i].spreads != nullptr) != keepsSpreads(how) || level.dims != shapes[i].dims ||
        level.type != finest.type)
      fail("{}: level {} is not that of {}{}", folder.string(), i + 1, finest.name,
           notes.empty() ? "" : ": " + notes.front());
    levels_.push_back(
        {found[i].source, placementOf(shapes[i]), found[i].spreads, false, valuesOf(how)});
  }
}

uint64_t LevelStore::digestOf(const fs::path& folder) {
  Digest digest;
  const auto addFile = [&](const fs::path& path) {
    File file(path);
    std::vector<std::byte> bytes(file.sizeBytes());
    file.readAt(0, bytes);
    digest.add(bytes);
  };
  addFile(folder / ".zattrs");
  const std::string text = ".zarray", sums(kZarrChecksumsName);
  for (const fs::path& parent : {folder, folder / kZarrSpreadFolder})
    for (int level = 0; fs::exists(parent / std::to_string(level) / text); ++level) {
      addFile(parent / std::to_string(level) / text);
      addFile(parent / std::to_string(level) / sums);
    }
  return digest.value();
}

}  // namespace sluice
