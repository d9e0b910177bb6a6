#include "src/cpu/least_opacity.h"

#include <algorithm>
#include <array>
#include <bit>

namespace sluice {
namespace {

using Row = std::array<double, 3>;
Vec3d asVec(const Row& row) {
  return {row[0], row[1], row[2]};
}

// Rows that take (clip x, clip y, 1) to the map, homogeneous, up to a factor whose sign is kept, so
// that w > 0 stays in front of the eye.
std::array<Vec3d, 3> mapFromClip(const MapGrid& grid) {
  const auto& clip = grid.clip_from_map;
  const Vec3d rows[3] = {asVec(clip[0]), asVec(clip[1]), asVec(clip[2])};
  // The columns of the adjugate: the inverse but for a factor.
  const double sign = dot(rows[0], cross(rows[1], rows[2])) < 0 ? -1 : 1;
  const Vec3d columns[3] = {cross(rows[1], rows[2]) * sign, cross(rows[2], rows[0]) * sign,
                            cross(rows[0], rows[1]) * sign};
  return {Vec3d{columns[0].x, columns[1].x, columns[2].x},
          Vec3d{columns[0].y, columns[1].y, columns[2].y},
          Vec3d{columns[0].z, columns[1].z, columns[2].z}};
}

// 0 if a cell reaches to the eye, else 1.
std::vector<std::atomic<uint32_t>> emptyCells(const MapGrid& grid) {
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
  // Relaxed: the cells are read after all threads have ended.
  uint32_t now = cell.load(std::memory_order_relaxed);
  while (to < now && !cell.compare_exchange_weak(now, to, std::memory_order_relaxed)) {
  }
}

// The cells around the rays of a row of pixels: every cell that rounding might put a ray in. None
// if `from` is beyond `to`. Plain loops over arrays, which compilers make vector code of.
struct RowCells {
  alignas(64) std::array<int32_t, kTileSide> u_from, u_to, v_from, v_to;
  bool areSame(size_t a, size_t b) const {
    return u_from[a] == u_from[b] && u_to[a] == u_to[b] && v_from[a] == v_from[b] &&
           v_to[a] == v_to[b];
  }
};
void findRange(const std::array<float, kTileSide>& at, int side,
               std::array<int32_t, kTileSide>& from, std::array<int32_t, kTileSide>& to) {
  constexpr float kMargin = 1e-3F;
  const auto end = static_cast<float>(side);
  for (size_t i = 0; i < kTileSide; ++i) {
    // Adding 1 makes the conversion round down; NaN counts as beyond the map.
    const float held = at[i] > -1 ? std::min(at[i], end + 1) : -1.0F;
    from[i] = std::max(static_cast<int32_t>(held - kMargin + 1) - 1, 0);
    to[i] = std::min(static_cast<int32_t>(held + kMargin + 1) - 1, side - 1);
  }
}

// The cells of a row of pixels. `start` is the first pixel's homogeneous place on the map, `pace`
// the difference from pixel to pixel.
RowCells rowCells(const Vec3d& start, const Vec3d& pace, int side) {
  const auto u0 = static_cast<float>(start.x), v0 = static_cast<float>(start.y),
             w0 = static_cast<float>(start.z);
  const auto du = static_cast<float>(pace.x), dv = static_cast<float>(pace.y),
             dw = static_cast<float>(pace.z);
  constexpr float kBeyond = -2;
  alignas(64) std::array<float, kTileSide> u, v;
  for (int x = 0; x < kTileSide; ++x) {
    const auto at = static_cast<float>(x), w = w0 + at * dw;
    const float on_u = (u0 + at * du) / w, on_v = (v0 + at * dv) / w;
    u[static_cast<size_t>(x)] = w > 0 ? on_u : kBeyond;
    v[static_cast<size_t>(x)] = w > 0 ? on_v : kBeyond;
  }
  RowCells cells;
  findRange(u, side, cells.u_from, cells.u_to);
  findRange(v, side, cells.v_from, cells.v_to);
  return cells;
}

}  // namespace

LeastOpacity::LeastOpacity(const MapGrid& grid, PictureSize size)
    : size_(size), side_(grid.side), cells_(emptyCells(grid)) {
  const auto map_from_clip = mapFromClip(grid);
  to_u_ = map_from_clip[0];
  to_v_ = map_from_clip[1];
  to_w_ = map_from_clip[2];
}

void LeastOpacity::add(const TiledPicture& picture, const TilePixels& pixels) {
  const float* opacity = pixels.color[3];
  const Vec3d a_pixel{2.0 / size_.width, 2.0 / size_.height, 0};
  const int count = std::min(kTileSide, size_.width - pixels.x);
  for (int y = 0; y < std::min(kTileSide, size_.height - pixels.y); ++y) {
    const Vec3d clip{(pixels.x + 0.5) * a_pixel.x - 1, (pixels.y + y + 0.5) * a_pixel.y - 1, 1};
    const RowCells row = rowCells({dot(to_u_, clip), dot(to_v_, clip), dot(to_w_, clip)},
                                  Vec3d{to_u_.x, to_v_.x, to_w_.x} * a_pixel.x, side_);
    // Neighbours are in the same cells most often.
    for (int x = 0; x < count;) {
      const auto first = static_cast<size_t>(x);
      // A tile that was not begun is transparent.
      float least = opacity != nullptr ? 1.0F : 0.0F;
      do {
        if (opacity != nullptr) least = std::min(least, opacity[picture.placeOf(x, y)]);
      } while (++x < count && row.areSame(first, static_cast<size_t>(x)));
      const auto bits = std::bit_cast<uint32_t>(std::max(least, 0.0F));
      for (int v = row.v_from[first]; v <= row.v_to[first]; ++v)
        for (int u = row.u_from[first]; u <= row.u_to[first]; ++u) {
          const int cell = v * side_ + u;
          lower(cells_[static_cast<size_t>(cell)], bits);
        }
    }
  }
}

std::vector<float> LeastOpacity::cells() const {
  std::vector<float> least;
  least.reserve(cells_.size());
  for (const auto& cell : cells_) least.push_back(std::bit_cast<float>(cell.load()));
  return least;
}

}  // namespace sluice
