#include "src/render/light/arriving_light.h"

#include <algorithm>
#include <cmath>

#include "src/render/camera/frame_setup.h"
#include "src/render/camera/index_space.h"
#include "src/render/light/light_sweep.h"

namespace sluice {
namespace {

// The sweep of light from a direction of the world.
Sweep sweepFrom(const VolumeLayout& layout, const CoarseGrid& grid, Vec3d toward, double reach) {
  const Vec3d texels = indexFromWorldDirection(layout, normalized(toward)) / toDouble(grid.voxels);
  return {texels, 1 / finestSpacing(layout), reach};
}

std::vector<float> ambientLight(const VolumeLayout& layout, const CoarseExtinction& matter,
                                WorkerPool& pool, const StopToken& stop) {
  double longest = 0;
  for (int a = 0; a < 3; ++a)
    longest = std::max(longest, layout.spacing[a] * static_cast<double>(layout.dims[a]));
  // Ambient light dims over a reach that grows with the volume, so that small and large volumes
  // look alike.
  const double reach = kAmbientReach * longest / finestSpacing(layout);
  std::vector<float> sums(matter.per_length.size(), 0.0F);
  // Twice the mean, so that a place on an open plane, whose directions are dark by half, keeps all
  // light.
  constexpr float kWeight = 2.0F / kAmbientDirections;
  const auto add = [&](Vec3d toward) {
    stop.throwIfStopped();
    addLight(matter, sweepFrom(layout, matter.grid, toward, reach), kWeight, pool, sums);
  };
  // The 6 directions along the axes and the 8 along the diagonals.
  for (const double end : {-1.0, 1.0}) {
    for (int a = 0; a < 3; ++a) {
      Vec3d toward;
      toward[a] = end;
      add(toward);
    }
    for (const double y : {-1.0, 1.0})
      for (const double x : {-1.0, 1.0}) add({x, y, end});
  }
  for (float& sum : sums) sum = std::min(sum, 1.0F);
  return sums;
}

// The planes of the crop and the clip planes, in index space; empty: all of the volume shows.
std::vector<ClipPlane> planesAround(const VolumeLayout& layout, const FrameOptions& options) {
  std::vector<ClipPlane> planes;
  if (options.crop) {
    const Box3 cells = cropCells(options, layout.dims);
    for (int a = 0; a < 3; ++a) {
      Vec3d normal;
      normal[a] = 1;
      // The last cell has no plane behind it, and the first none before it.
      if (cells.hi[a] < layout.dims[a] - 1)
        planes.push_back({normal, static_cast<double>(cells.hi[a])});
      if (cells.lo[a] > 0) planes.push_back({-normal, -static_cast<double>(cells.lo[a])});
    }
  }
  const std::vector<ClipPlane> clips = clipPlanes(options.clip_planes, layout);
  planes.insert(planes.end(), clips.begin(), clips.end());
  return planes;
}

// The number of a texel for a share of the light, of which `strength` may be taken away.
uint16_t numberOf(double share, double strength) {
  return static_cast<uint16_t>(std::lround(kAllLight * (1 - strength * (1 - share))));
}

}  // namespace

LightVolumePtr ArrivingLight::of(const TimeStep& step, const LookPtr& look, MatterFrom from,
                                 const View& view, const FrameOptions& options, WorkerPool& pool) {
  const Lighting& lighting = options.lighting;
  if (!lighting.looksAround()) return nullptr;
  const VolumeLayout& layout = step.source->layout();
  // The matter is kept for all views and lights, since it takes a pass over the voxels.
  const VoxelPlanes planes = planesOf(options.crop, layout.dims);
  const CoarseExtinctionPtr whole = matter_[from == MatterFrom::kFinest ? 0 : 1].of(
      {step.source, step.time, look, planes},
      [&] { return coarseExtinction(step, *look, from, pool, options.stop, planes); });
  const std::vector<ClipPlane> sides = planesAround(layout, options);
  // Crop and clip planes take away matter, so that what they hide casts no shadow.
  const CoarseExtinctionPtr matter =
      sides.empty() ? whole : shown_.of({whole, sides}, [&] { return within(*whole, sides); });
  const Vec3d key = lighting.lights[0].toward;
  const Sweep to_key = sweepFrom(layout, matter->grid,
                                 view.right * key.x + view.up * key.y - view.forward * key.z, 0);
  // Without shadows the direction is not part of the key.
  const Vec3d direction = lighting.shadows > 0 ? to_key.toward : Vec3d{};
  return light_.of({matter, direction, lighting.shadows, lighting.occlusion}, [&] {
    const size_t count = matter->per_length.size();
    Numbers of_key(lighting.shadows > 0 ? count : 0, 0.0F);
    if (lighting.shadows > 0) addLight(*matter, to_key, 1, pool, of_key);
    std::shared_ptr<const Numbers> ambient;
    // Ambient light does not depend on the view: it is kept apart from the key light's.
    if (lighting.occlusion > 0)
      ambient =
          ambient_.of(matter, [&] { return ambientLight(layout, *matter, pool, options.stop); });
    LightVolume light;
    light.dims = matter->grid.texels;
    const Vec3d voxels = toDouble(matter->grid.voxels);
    light.scale = Vec3d{1, 1, 1} / voxels;
    light.offset = matter->grid.centerOf({0, 0, 0}) / voxels * -1.0;
    light.key_varies = !of_key.empty();
    light.other_varies = ambient != nullptr;
    light.texels.reserve(2 * count);
    for (size_t i = 0; i < count; ++i) {
      // Light that does not vary is all there: its number is a constant.
      light.texels.push_back(of_key.empty() ? static_cast<uint16_t>(kAllLight)
                                            : numberOf(of_key[i], lighting.shadows));
      light.texels.push_back(ambient == nullptr ? static_cast<uint16_t>(kAllLight)
                                                : numberOf((*ambient)[i], lighting.occlusion));
    }
    return light;
  });
}

uint64_t lightBytes(const VolumeLayout& layout, int threads) {
  const auto texels = static_cast<uint64_t>(coarseGrid(layout).count());
  // Extinctions, of both sources, cropped, and those that the cropped ones were made of; the sums
  // that they are means of, or the key and the ambient light; the light volume, and its copy on a
  // device that has textures in memory or keeps it in squares (src/cpu/light_squares.h).
  constexpr uint64_t kTexelBytes = 4 * sizeof(float) + 2 * sizeof(double) + 4 + 8;
  const uint64_t read = static_cast<uint64_t>(std::min(kMostCoarseVoxelsRead, volume(layout.dims)));
  return texels * kTexelBytes +
         static_cast<uint64_t>(threads) * read * bytesPerVoxel(deviceMap(layout).type) * 2;
}

}  // namespace sluice
