#include "tools/commands/debug_views.h"

#include <fmt/format.h>

#include <cstring>

#include "io/pictures/png_file.h"
#include "src/base/error.h"
#include "src/index/box_store.h"
#include "tools/command_line/interrupt.h"

namespace sluice {
namespace {

constexpr int64_t kBoxesSide = 768;  // pixels that a small slice is blown up to
constexpr int64_t kMapScale = 8;
constexpr uint64_t kTreeBytes = uint64_t{16} << 20;
// --memory is the session's: a block for each thread.
constexpr uint64_t kGrowingBytes = 0;

using Color = std::array<float, 3>;
// The colours of the paper's Figure 2.
Color colorOf(BoxType type) {
  switch (type) {
    case BoxType::kUniform:
      return {0.9F, 0.2F, 0.2F};
    case BoxType::kGradient:
      return {0.3F, 0.4F, 1.0F};
    case BoxType::kOther:
      break;
  }
  return {0.2F, 0.8F, 0.3F};
}

Picture canvas(int64_t width, int64_t height) {
  Picture picture;
  picture.width = static_cast<int>(width);
  picture.height = static_cast<int>(height);
  picture.rgba.assign(static_cast<size_t>(4 * width * height), 1.0F);
  return picture;
}

// y upwards, as volumes have it.
void put(Picture& picture, int64_t x, int64_t y, const Color& color, float share) {
  float* pixel =
      &picture.rgba[static_cast<size_t>(4 * ((picture.height - 1 - y) * picture.width + x))];
  for (size_t c = 0; c < 3; ++c) pixel[c] += share * (color[c] - pixel[c]);
}

// Values from 0 to 1 of the voxels of one z plane, x fastest.
std::vector<float> greySlice(const Scene& scene, int64_t time, int64_t z) {
  VolumeSource& source = *scene.volume.source;
  const VolumeLayout& layout = source.layout();
  const Box3 plane{{0, 0, z}, {layout.dims.x, layout.dims.y, z + 1}};
  std::vector<std::byte> bytes(static_cast<size_t>(plane.count()) * bytesPerVoxel(layout.type));
  source.readRegion(time, plane, bytes);
  const ValueRange range = scene.volume.valueRange();
  std::vector<float> grey;
  visitVoxelType(layout.type, [&](auto voxel) {
    for (size_t at = 0; at < bytes.size(); at += sizeof voxel) {
      std::memcpy(&voxel, &bytes[at], sizeof voxel);
      const double value = static_cast<double>(voxel) * layout.value_scale + layout.value_offset;
      grey.push_back(
          static_cast<float>((value - range.lo) / std::max(range.hi - range.lo, 1e-300)));
    }
  });
  return grey;
}

void drawBox(Picture& picture, const Box3& cells, BoxType type, int64_t scale) {
  // Maps voxel centres to pixel centres.
  const auto pixel = [&](int64_t voxel, int64_t most) {
    return std::min(voxel * scale + scale / 2, most - 1);
  };
  const int64_t x0 = pixel(cells.lo.x, picture.width), x1 = pixel(cells.hi.x, picture.width);
  const int64_t y0 = pixel(cells.lo.y, picture.height), y1 = pixel(cells.hi.y, picture.height);
  for (int64_t y = y0; y <= y1; ++y)
    for (int64_t x = x0; x <= x1; ++x) {
      const bool edge = x == x0 || x == x1 || y == y0 || y == y1;
      put(picture, x, y, colorOf(type), edge ? 1.0F : 0.25F);
    }
}

Picture boxesPicture(Scene& scene, const VolumeArguments& volume, const IndexPlaces& places) {
  const SliceRanges& ranges = scene.volume.index->ranges;
  const BlockLayout& layout = ranges.layout;
  const int64_t z = layout.dims.z / 2;
  const int64_t scale = std::max<int64_t>(1, kBoxesSide / std::max(layout.dims.x, layout.dims.y));
  Picture picture = canvas(layout.dims.x * scale, layout.dims.y * scale);
  const std::vector<float> grey = greySlice(scene, volume.time, z);
  for (int64_t y = 0; y < picture.height; ++y)
    for (int64_t x = 0; x < picture.width; ++x) {
      const float value = grey[static_cast<size_t>(y / scale * layout.dims.x + x / scale)];
      put(picture, x, y, {value, value, value}, 1);
    }
  BoxStore store(*scene.volume.source, places, volume.time, ranges, scene.pool, kTreeBytes,
                 kGrowingBytes);
  // The last slice may lie in no cell: there is one fewer of them than voxels.
  const int64_t layer = std::min(z / layout.cells(), layout.grid.z - 1);
  for (int64_t y = 0; y < layout.grid.y; ++y)
    for (int64_t x = 0; x < layout.grid.x; ++x) {
      const Vec3i index{x, y, layer};
      const Vec3i first = layout.ownedCells(index).lo;
      // The store may let go of it.
      const BoxTreePtr tree = store.tree(layout.idOf(index), {.stop = interruption()});
      for (const GrownBox& box : tree->boxes) {
        const Box3 cells = translate(box.local(), first);
        if (cells.lo.z <= z && z < cells.hi.z) drawBox(picture, cells, box.type, scale);
      }
    }
  return picture;
}

Picture mapPicture(const OpacityMap& map) {
  Picture picture = canvas(map.side() * kMapScale, map.side() * kMapScale);
  for (int64_t y = 0; y < picture.height; ++y)
    for (int64_t x = 0; x < picture.width; ++x) {
      const float opacity =
          map.at(static_cast<int>(x / kMapScale), static_cast<int>(y / kMapScale));
      put(picture, x, y, {opacity, opacity, opacity}, 1);
    }
  return picture;
}

std::filesystem::path debugViewName(const std::filesystem::path& output, const std::string& what) {
  return output.parent_path() / (output.stem().string() + "." + what + ".png");
}

}  // namespace

std::vector<std::filesystem::path> debugViewNames(const std::filesystem::path& output) {
  constexpr int kMostPhases = 256;  // more than a frame ever has
  std::vector<std::filesystem::path> names = {debugViewName(output, "boxes")};
  for (int i = 0; i < kMostPhases; ++i)
    for (const char* what : {"drawn", "map"})
      names.push_back(debugViewName(output, fmt::format("{}_{}", what, i)));
  return names;
}

std::vector<std::filesystem::path> writeDebugViews(const std::filesystem::path& output,
                                                   const Frame& frame, Scene& scene,
                                                   const VolumeArguments& volume,
                                                   const IndexPlaces& places, Partition partition) {
  std::vector<std::filesystem::path> written;
  const auto write = [&](const std::string& what, const Picture& picture) {
    written.push_back(debugViewName(output, what));
    writePng(written.back(), picture, interruption());
  };
  if (partition == Partition::kBoxes) write("boxes", boxesPicture(scene, volume, places));
  for (size_t i = 0; i < frame.phases.size(); ++i) {
    write(fmt::format("drawn_{}", i), frame.phases[i].picture);
    if (frame.phases[i].map) write(fmt::format("map_{}", i), mapPicture(*frame.phases[i].map));
  }
  return written;
}

}  // namespace sluice
