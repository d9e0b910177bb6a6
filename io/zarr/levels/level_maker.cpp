#include "io/zarr/levels/level_maker.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "io/zarr/levels/extreme_levels.h"
#include "io/zarr/levels/gathered_levels.h"
#include "io/zarr/levels/narrow_means.h"
#include "io/zarr/reading/zarr_rows.h"
#include "src/base/error.h"
#include "src/base/memory/large_pages.h"

namespace sluice {
namespace {

uint64_t layerBytes(const LevelShape& level, int64_t chunk_voxels, size_t voxel) {
  return static_cast<uint64_t>(level.dims.x * level.dims.y * std::min(chunk_voxels, level.dims.z)) *
         voxel;
}

std::vector<Vec3i> stepsOf(std::span<const LevelShape> levels) {
  std::vector<Vec3i> steps;
  for (const LevelShape& level : levels) steps.push_back(level.step);
  return steps;
}

}  // namespace

struct LevelMaker::Scratch {
  GatheredRoom gathered;
  std::vector<std::byte> narrow;
};

LevelMaker::~LevelMaker() = default;

LevelMaker::LevelMaker(const VolumeLayout& layout, int64_t chunk_voxels,
                       std::vector<LevelShape> levels, Downsample how,
                       std::span<const std::byte> fill)
    : dims_(layout.dims),
      type_(layout.type),
      chunk_voxels_(chunk_voxels),
      levels_(std::move(levels)),
      how_(how),
      fill_(fill.begin(), fill.end()),
      layers_(levels_.size()) {
  const size_t spread = keepsSpreads(how) ? bytesPerVoxel(spreadType(type_)) : 0;
  const auto inLines = [&](const LevelShape& level, size_t voxel) {
    const auto line = static_cast<uint64_t>(kArrayAlignment);
    return (layerBytes(level, chunk_voxels, voxel) + line - 1) / line * line;
  };
  uint64_t bytes = 0;
  for (const LevelShape& level : levels_)
    bytes += inLines(level, fill_.size()) + inLines(level, spread);
  room_ = alignedForOverwrite<std::byte>(bytes);
  preferLargePages({room_.get(), bytes});
  std::byte* next = room_.get();
  for (size_t i = 0; i < levels_.size(); ++i) {
    const LevelShape& level = levels_[i];
    // Cubes of finest chunks must make whole voxels of each level, or two threads would share some.
    for (int a = 0; a < 3; ++a) SLUICE_CHECK_EQ(chunk_voxels % level.step[a], 0);
    layers_[i].voxels = next;
    next += inLines(level, fill_.size());
    if (spread > 0) layers_[i].spreads = next;
    next += inLines(level, spread);
    layers_[i].came.resize(static_cast<size_t>(volume(cubesOf(i))));
  }
}

uint64_t LevelMaker::pendingBytes(const VolumeLayout& layout, int64_t chunk_voxels,
                                  std::span<const LevelShape> levels, Downsample how) {
  uint64_t bytes = 0;
  for (const LevelShape& level : levels)
    bytes += layerBytes(level, chunk_voxels,
                        storedBytesPerVoxel(layout.type, keepsSpreads(how) ? 2 : 1));
  return bytes;
}

uint64_t LevelMaker::threadBytes(const VolumeLayout& layout, int64_t chunk_voxels) {
  const auto side = static_cast<uint64_t>(chunk_voxels);
  // Blocks of the first level, perhaps of one axis halved, and of the second; or a block's voxels.
  return side * side * side * std::max(sizeof(BlockSums), bytesPerVoxel(layout.type));
}

int64_t LevelMaker::longestRow() const {
  const bool is_extreme = how_ == Downsample::kMax || how_ == Downsample::kMin;
  if (is_extreme) return ceilDiv(dims_.x, chunk_voxels_) * chunk_voxels_;
  if (bytesPerVoxel(type_) > 2 || how_ != Downsample::kMean) return chunk_voxels_;
  const int64_t side = chunk_voxels_;
  const uint64_t cube = narrowMeansRoom({side, side, side}, stepsOf(levels_));
  VolumeLayout layout;
  layout.type = type_;
  const uint64_t most = threadBytes(layout, side);
  return side * static_cast<int64_t>(std::max<uint64_t>(1, most / std::max<uint64_t>(1, cube)));
}

Box3 LevelMaker::layerAt(size_t level, int64_t z) const {
  const LevelShape& shape = levels_[level];
  const int64_t first = z / shape.step.z / chunk_voxels_ * chunk_voxels_;
  return {{0, 0, first},
          {shape.dims.x, shape.dims.y, std::min(first + chunk_voxels_, shape.dims.z)}};
}

Vec3i LevelMaker::cubesOf(size_t level) const {
  return {ceilDiv(dims_.x, chunk_voxels_), ceilDiv(dims_.y, chunk_voxels_), levels_[level].step.z};
}

void LevelMaker::endLayer(size_t level) {
  Layer& layer = layers_[level];
  const Vec3i cubes = cubesOf(level);
  size_t i = 0;
  for (int64_t z = 0; z < cubes.z; ++z)
    for (int64_t y = 0; y < cubes.y; ++y)
      for (int64_t x = 0; x < cubes.x; ++x, ++i)
        // Empty cubes do not come; clearing whole layers before would be one more pass over them.
        if (layer.came[i] == 0) fillPlaceOf(level, {x, y, z});
  std::fill(layer.came.begin(), layer.came.end(), char{0});
}

void LevelMaker::fillPlaceOf(size_t level, Vec3i cube) {
  Layer& layer = layers_[level];
  const LevelShape& shape = levels_[level];
  const Vec3i side{chunk_voxels_, chunk_voxels_, chunk_voxels_};
  const int64_t planes = std::min(chunk_voxels_, shape.dims.z);
  const Box3 place =
      intersect({cube * side / shape.step, (cube + Vec3i{1, 1, 1}) * side / shape.step},
                boxOf({shape.dims.x, shape.dims.y, planes}));
  if (place.empty()) return;
  const size_t spread = keepsSpreads(how_) ? bytesPerVoxel(spreadType(type_)) : 0;
  for (int64_t z = place.lo.z; z < place.hi.z; ++z)
    for (int64_t y = place.lo.y; y < place.hi.y; ++y) {
      const auto at = static_cast<size_t>((z * shape.dims.y + y) * shape.dims.x + place.lo.x);
      const auto count = static_cast<size_t>(place.size().x);
      fillRow(fill_, layer.voxels + at * fill_.size(), place.size().x);
      if (spread > 0) std::memset(layer.spreads + at * spread, 0, count * spread);
    }
}

void LevelMaker::add(const Box3& box, const std::byte* voxels, int64_t row_stride,
                     int64_t plane_stride) {
  visitVoxelType(type_, [&](auto tag) {
    using T = decltype(tag);
    addOf<T>(box, reinterpret_cast<const T*>(voxels), row_stride, plane_stride);
  });
}

template <class T>
void LevelMaker::addOf(const Box3& box, const T* voxels, int64_t row_stride, int64_t plane_stride) {
  std::unique_ptr<Scratch> scratch;
  {
    const MutexLock lock(mutex_);
    if (!idle_.empty()) {
      scratch = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (scratch == nullptr) scratch = std::make_unique<Scratch>();
  std::vector<LevelPart> parts;
  const Vec3i cube = box.lo / Vec3i{chunk_voxels_, chunk_voxels_, chunk_voxels_};
  const auto cubes = static_cast<size_t>(ceilDiv(box.size().x, chunk_voxels_));
  for (size_t i = 0; i < levels_.size(); ++i) {
    const LevelShape& level = levels_[i];
    const Vec3i first = box.lo / level.step - layerAt(i, box.lo.z).lo, count = cubesOf(i);
    const int64_t plane = level.dims.x * level.dims.y;
    const auto at = static_cast<size_t>(first.z * plane + first.y * level.dims.x + first.x);
    // No lock: cubes are aligned to voxels of all levels, so that threads write to different ones.
    LevelPart part{level.step, layers_[i].voxels + at * sizeof(T), nullptr, level.dims.x, plane};
    if (keepsSpreads(how_)) part.spreads = layers_[i].spreads + at * sizeof(SpreadOf<T>);
    parts.push_back(part);
    const auto came =
        layers_[i].came.begin() + ((cube.z % count.z) * count.y + cube.y) * count.x + cube.x;
    std::fill_n(came, cubes, char{1});
  }
  const CubeVoxels<T> all{box.size(), voxels, row_stride, plane_stride};
  switch (how_) {
    case Downsample::kMax:
    case Downsample::kMin:
      extremeLevels(all, parts, how_);
      break;
    case Downsample::kMean:
      if constexpr (kIsNarrow<T>)
        narrowMeans(all, parts, scratch->narrow);
      else
        gatheredLevels(all, parts, how_, scratch->gathered);
      break;
    case Downsample::kMode:
      gatheredLevels(all, parts, how_, scratch->gathered);
      break;
  }
  const MutexLock lock(mutex_);
  idle_.push_back(std::move(scratch));
}

}  // namespace sluice
