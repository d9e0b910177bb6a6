#include "src/cpu/tiled_picture.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>

#include "src/base/large_pages.h"
#include "src/device/look_up_texels.h"

namespace sluice {
namespace {

constexpr size_t kColors = 4, kStopped = 4, kDepth = 5;
constexpr size_t kAlignedFloats = 64 / sizeof(float);

using Row = std::array<double, 3>;
Vec3d asVec(const Row& row) {
  return {row[0], row[1], row[2]};
}

// Rows that take (clip x, clip y, 1) to the map, homogeneous, up to a factor whose sign is kept, so
// that w > 0 stays in front of the eye.
std::array<Vec3d, 3> mapFromClip(const MapGrid& grid) {
  const auto& clip = grid.clip_from_map;
  const Vec3d rows[3] = {asVec(clip[0]), asVec(clip[1]), asVec(clip[2])};
  const double sign = dot(rows[0], cross(rows[1], rows[2])) < 0 ? -1 : 1;
  const Vec3d columns[3] = {cross(rows[1], rows[2]) * sign, cross(rows[2], rows[0]) * sign,
                            cross(rows[0], rows[1]) * sign};
  return {Vec3d{columns[0].x, columns[1].x, columns[2].x},
          Vec3d{columns[0].y, columns[1].y, columns[2].y},
          Vec3d{columns[0].z, columns[1].z, columns[2].z}};
}

// 0 where a cell reaches to the eye, else 1.
std::vector<std::atomic<uint32_t>> emptyMap(const MapGrid& grid) {
  constexpr double kLeastW = 1e-6;
  const auto side = static_cast<size_t>(grid.side);
  std::vector<std::atomic<uint32_t>> cells(side * side);
  const Vec3d w = asVec(grid.clip_from_map[2]);
  for (size_t j = 0; j < side; ++j)
    for (size_t i = 0; i < side; ++i) {
      bool reaches = false;
      for (size_t corner = 0; corner < 4; ++corner)
        reaches = reaches || dot(w, {static_cast<double>(i + (corner & 1)),
                                     static_cast<double>(j + (corner >> 1)), 1}) < kLeastW;
      cells[j * side + i] = std::bit_cast<uint32_t>(reaches ? 0.0F : 1.0F);
    }
  return cells;
}

// Floats that are not negative are ordered as their bits are.
void lower(std::atomic<uint32_t>& cell, uint32_t to) {
  uint32_t now = cell.load(std::memory_order_relaxed);
  while (to < now && !cell.compare_exchange_weak(now, to, std::memory_order_relaxed)) {
  }
}

// Into the cells around (u, v): those that it is in, whatever rounding says.
// Requires: -1 < u, v < side + 1.
void lowerAround(std::vector<std::atomic<uint32_t>>& cells, int side, double u, double v,
                 uint32_t to) {
  constexpr double kMargin = 1e-3;
  // One more, so that whole numbers are cut off downwards; -1 and `side` are no cells.
  const auto cellOf = [](double at) { return static_cast<int>(at + 1) - 1; };
  const int u_lo = std::max(0, cellOf(u - kMargin)), u_hi = std::min(side - 1, cellOf(u + kMargin)),
            v_lo = std::max(0, cellOf(v - kMargin)), v_hi = std::min(side - 1, cellOf(v + kMargin));
  for (int y = v_lo; y <= v_hi; ++y)
    for (int x = u_lo; x <= u_hi; ++x)
      lower(cells[static_cast<size_t>(y) * static_cast<size_t>(side) + static_cast<size_t>(x)], to);
}

}  // namespace

void TiledPicture::clear(const FrameSetup& setup, const Kernels& kernels) {
  for (int i = 0; i < kTilePixels; ++i)
    place_[static_cast<size_t>(i)] = kernels.placeOf(i % kTileSide, i / kTileSide);
  size_ = setup.size;
  across_ = (size_.width + kTileSide - 1) / kTileSide;
  up_ = (size_.height + kTileSide - 1) / kTileSide;
  with_depth_ = setup.mode == Mode::kComposite && setup.with_depth;
  arrays_ = with_depth_ ? kDepth + 1 : kStopped + 1;
  const size_t floats = floatsATile() * static_cast<size_t>(tiles());
  if (memory_.size() < floats + kAlignedFloats) {
    memory_.clear();
    reserveLarge(memory_, floats + kAlignedFloats);
    memory_.resize(floats + kAlignedFloats);
  }
  const auto address = reinterpret_cast<uintptr_t>(memory_.data());
  pixels_ = memory_.data() + (64 - address % 64) % 64 / sizeof(float);
  const float start = setup.mode == Mode::kMip     ? std::numeric_limits<float>::lowest()
                      : setup.mode == Mode::kMinip ? std::numeric_limits<float>::max()
                                                   : 0.0F;
  pool_.parallelFor(up_, [&](int64_t row) {
    for (int64_t i = row * across_; i < (row + 1) * across_; ++i) {
      float* floats_of = pixels_ + static_cast<size_t>(i) * floatsATile();
      std::fill_n(floats_of, kColors * kTilePixels, start);
      std::fill_n(floats_of + kStopped * kTilePixels, (arrays_ - kStopped) * kTilePixels, 0.0F);
    }
  });
}

TilePixels TiledPicture::tile(int64_t index) {
  float* floats = pixels_ + static_cast<size_t>(index) * floatsATile();
  TilePixels result;
  result.x = static_cast<int>(index % across_) * kTileSide;
  result.y = static_cast<int>(index / across_) * kTileSide;
  for (size_t channel = 0; channel < kColors; ++channel)
    result.color[channel] = floats + channel * kTilePixels;
  result.stopped = floats + kStopped * kTilePixels;
  if (with_depth_) result.depth_sum = floats + kDepth * kTilePixels;
  return result;
}

std::vector<float> TiledPicture::leastOpacity(const MapGrid& grid) {
  std::vector<std::atomic<uint32_t>> cells = emptyMap(grid);
  const auto map_from_clip = mapFromClip(grid);
  const Vec3d to_u = map_from_clip[0], to_v = map_from_clip[1], to_w = map_from_clip[2];
  const Vec3d a_pixel{2.0 / size_.width, 2.0 / size_.height, 0};
  // Of a parallel view all pixels have the same w: no division for each.
  const bool parallel = to_w.x == 0 && to_w.y == 0;
  pool_.parallelFor(tiles(), [&](int64_t index) {
    const TilePixels pixels = tile(index);
    const int count = std::min(kTileSide, size_.width - pixels.x);
    for (int y = 0; y < std::min(kTileSide, size_.height - pixels.y); ++y) {
      const Vec3d clip{(pixels.x + 0.5) * a_pixel.x - 1, (pixels.y + y + 0.5) * a_pixel.y - 1, 1};
      const double u0 = dot(to_u, clip), v0 = dot(to_v, clip), w0 = dot(to_w, clip);
      double to_unit = 1 / w0;
      for (int x = 0; x < count; ++x) {
        const double w = w0 + x * a_pixel.x * to_w.x;
        if (!(w > 0)) continue;
        if (!parallel) to_unit = 1 / w;
        const double u = (u0 + x * a_pixel.x * to_u.x) * to_unit;
        const double v = (v0 + x * a_pixel.x * to_v.x) * to_unit;
        if (!(u > -1 && v > -1 && u < grid.side + 1 && v < grid.side + 1)) continue;
        const float opacity = pixels.color[3][placeOf(x, y)];
        lowerAround(cells, grid.side, u, v, std::bit_cast<uint32_t>(std::max(opacity, 0.0F)));
      }
    }
  });
  std::vector<float> least;
  least.reserve(cells.size());
  for (const auto& cell : cells) least.push_back(std::bit_cast<float>(cell.load()));
  return least;
}

void TiledPicture::stopOpaque(float opacity) {
  pool_.parallelFor(tiles(), [&](int64_t index) {
    const TilePixels pixels = tile(index);
    for (int i = 0; i < kTilePixels; ++i)
      pixels.stopped[i] = pixels.color[3][i] >= opacity ? 1.0F : 0.0F;
  });
}

void TiledPicture::copyTo(const FrameSetup& setup, Picture& picture) {
  const auto width = static_cast<size_t>(size_.width), height = static_cast<size_t>(size_.height);
  picture.width = size_.width;
  picture.height = size_.height;
  if (picture.rgba.capacity() < 4 * width * height) {
    picture.rgba.clear();
    reserveLarge(picture.rgba, 4 * width * height);
  }
  picture.rgba.resize(4 * width * height);
  picture.depth.resize(with_depth_ ? width * height : 0);
  pool_.parallelFor(tiles(), [&](int64_t index) {
    const TilePixels pixels = tile(index);
    const auto& [red, green, blue, opacity] = pixels.color;
    const int count = std::min(kTileSide, size_.width - pixels.x);
    for (int y = 0; y < std::min(kTileSide, size_.height - pixels.y); ++y) {
      const size_t to =
          (height - 1 - static_cast<size_t>(pixels.y + y)) * width + static_cast<size_t>(pixels.x);
      float* out = picture.rgba.data() + 4 * to;
      for (int x = 0; x < count; ++x, out += 4) {
        const size_t from = placeOf(x, y);
        out[0] = red[from];
        out[1] = green[from];
        out[2] = blue[from];
        out[3] = opacity[from];
      }
      if (!with_depth_) continue;
      for (int x = 0; x < count; ++x) {
        const size_t from = placeOf(x, y);
        // Nothing there: infinitely far, as renderers write it.
        picture.depth[to + static_cast<size_t>(x)] = opacity[from] > 0
                                                         ? pixels.depth_sum[from] / opacity[from]
                                                         : std::numeric_limits<float>::infinity();
      }
    }
  });
  if (setup.mode != Mode::kComposite && !setup.is_part) resolveMode(setup, 1, picture.rgba);
}

}  // namespace sluice
