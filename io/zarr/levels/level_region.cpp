#include "io/zarr/levels/level_region.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "io/zarr/levels/level_maker.h"
#include "io/zarr/levels/level_part.h"

namespace sluice {

void makeLevelRegion(VolumeSource& finest, int64_t time, const LevelShape& level, Downsample how,
                     const Box3& box, std::span<std::byte> voxels, std::span<std::byte> spreads) {
  const VolumeLayout& layout = finest.layout();
  const Vec3i from = box.lo * level.step, size = min(box.hi * level.step, layout.dims) - from;
  const int64_t side = std::max({level.step.x, level.step.y, level.step.z});
  VolumeLayout part = layout;
  part.dims = size;
  const size_t voxel = bytesPerVoxel(layout.type);
  const std::vector<std::byte> fill(voxel);
  // With the levels between, since each is gathered from the one before.
  std::vector<LevelShape> levels;
  for (Vec3i step{1, 1, 1}; step != level.step;) {
    step = min(step * 2, level.step);
    levels.push_back({blocksOf(size, step), step});
  }
  const size_t last = levels.size() - 1;
  LevelMaker maker(part, side, std::move(levels), how, fill);
  std::vector<std::byte> cube(static_cast<size_t>(side * side * side) * voxel);
  const auto copyLayer = [&](const Box3& layer, const std::byte* made, std::span<std::byte> to) {
    if (to.empty()) return;
    const size_t plane = to.size() / static_cast<size_t>(box.size().z);
    std::memcpy(to.data() + plane * static_cast<size_t>(layer.lo.z), made,
                plane * static_cast<size_t>(layer.size().z));
  };
  for (int64_t z = 0; z < size.z; z += side) {
    for (int64_t y = 0; y < size.y; y += side)
      for (int64_t x = 0; x < size.x; x += side) {
        const Vec3i lo{x, y, z};
        const Box3 own = intersect({lo, lo + Vec3i{side, side, side}}, boxOf(size));
        finest.readRegion(time, translate(own, from),
                          std::span(cube).first(static_cast<size_t>(own.count()) * voxel));
        maker.add(own, cube.data(), own.size().x, own.size().x * own.size().y);
      }
    const Box3 layer = maker.layerAt(last, z);
    const int64_t end = std::min(z + side, size.z);
    if (end < size.z && end % (side * level.step.z) != 0) continue;
    maker.endLayer(last);
    copyLayer(layer, maker.layerVoxels(last), voxels);
    copyLayer(layer, maker.layerSpreads(last), spreads);
  }
}

}  // namespace sluice
