#include "src/cpu/tiled_picture.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "src/base/error.h"
#include "src/base/memory/large_pages.h"
#include "src/device/pictures/partial_picture.h"

namespace sluice {
namespace {

constexpr size_t kColors = 4, kStopped = 4,
                 kDepth = 5;  // channels, and the positions of the others
static_assert((kDepth + 1) * kTilePixels == TiledPicture::kMostFloats);
constexpr size_t kAlignedFloats = 64 / sizeof(float);

}  // namespace

void TiledPicture::begin(const FrameSetup& setup, const Kernels& kernels, PictureRows rows) {
  SLUICE_CHECK(rows.lo >= 0 && rows.lo < rows.hi && rows.hi <= setup.size.height);
  // Tiles have a fixed place in the whole picture, so that a strip's pixels are those of the whole.
  SLUICE_CHECK_EQ(rows.lo % kTileSide, 0);
  for (int i = 0; i < kTilePixels; ++i)
    place_[static_cast<size_t>(i)] = kernels.placeOf(i % kTileSide, i / kTileSide);
  size_ = setup.size;
  rows_ = rows;
  across_ = (size_.width + kTileSide - 1) / kTileSide;
  up_ = (rows_.hi - rows_.lo + kTileSide - 1) / kTileSide;
  with_depth_ = traitsOf(setup.mode).has_colors && setup.with_depth;
  arrays_ = with_depth_ ? kDepth + 1 : kStopped + 1;
  start_ = traitsOf(setup.mode).first_value;
  stop_number_ = 0;
  stops_.assign(static_cast<size_t>(tiles()), kNotBegun);
}

void TiledPicture::makeRoom() {
  // tile() clears each tile when it is begun, so nothing is cleared here.
  const size_t floats = floatsATile() * static_cast<size_t>(tiles()) + kAlignedFloats;
  if (memory_floats_ < floats) {
    memory_.reset();
    memory_floats_ = 0;
    memory_ = std::make_unique_for_overwrite<float[]>(floats);
    memory_floats_ = floats;
    preferLargePages(std::as_writable_bytes(std::span(memory_.get(), floats)));
  }
  const auto address = reinterpret_cast<uintptr_t>(memory_.get());
  pixels_ = memory_.get() + (64 - address % 64) % 64 / sizeof(float);
}

TilePixels TiledPicture::tileAt(int64_t index, float* floats) const {
  TilePixels result;
  result.x = static_cast<int>(index % across_) * kTileSide;
  result.y = rows_.lo + static_cast<int>(index / across_) * kTileSide;
  if (floats == nullptr) return result;
  for (size_t channel = 0; channel < kColors; ++channel)
    result.color[channel] = floats + channel * kTilePixels;
  result.stopped = floats + kStopped * kTilePixels;
  if (with_depth_) result.depth_sum = floats + kDepth * kTilePixels;
  return result;
}

void TiledPicture::empty(const TilePixels& pixels) const {
  std::fill_n(pixels.color[0], kColors * kTilePixels, start_);
  std::fill_n(pixels.stopped, (arrays_ - kStopped) * kTilePixels, 0.0F);
}

TilePixels TiledPicture::tile(int64_t index) {
  int32_t& stops = stops_[static_cast<size_t>(index)];
  const TilePixels pixels = tileAt(index, floatsOf(index));
  if (stops == kNotBegun) {
    empty(pixels);
  } else if (stops != stop_number_) {
    // stopOpaque() was called since the tile was drawn last: its opaque pixels are found now.
    for (int i = 0; i < kTilePixels; ++i)
      pixels.stopped[i] = pixels.color[3][i] >= stop_opacity_ ? 1.0F : 0.0F;
  }
  stops = stop_number_;
  return pixels;
}

TilePixels TiledPicture::tile(int64_t index, Scratch& scratch) {
  // A tile that was begun keeps its pixels.
  if (stops_[static_cast<size_t>(index)] != kNotBegun) return tile(index);
  const TilePixels pixels = tileAt(index, scratch.floats.data());
  empty(pixels);
  return pixels;
}

TilePixels TiledPicture::drawnTile(int64_t index) const {
  const bool is_begun = stops_[static_cast<size_t>(index)] != kNotBegun;
  return tileAt(index, is_begun ? floatsOf(index) : nullptr);
}

void TiledPicture::stopOpaque(float opacity) {
  // Tiles take notice when they are drawn next.
  stop_opacity_ = opacity;
  ++stop_number_;
}

namespace {

// values.resize(count) of cleared memory, piece by piece. Requires: the capacity.
void resizeInPieces(std::vector<float>& values, size_t count, const StopToken& stop) {
  // A large picture takes long to clear, and a stop is to be heard meanwhile.
  constexpr size_t kPiece = 8 << 20;
  while (values.size() < count) {
    stop.throwIfStopped();
    values.resize(std::min(count, values.size() + kPiece));
  }
  values.resize(count);
}

}  // namespace

void TiledPicture::shape(Picture& picture, const StopToken& stop) const {
  const auto width = static_cast<size_t>(size_.width),
             height = static_cast<size_t>(rows_.hi - rows_.lo);
  picture.width = size_.width;
  picture.height = rows_.hi - rows_.lo;
  if (picture.rgba.capacity() < 4 * width * height) {
    picture.rgba.clear();
    reserveLarge(picture.rgba, 4 * width * height);
  }
  resizeInPieces(picture.rgba, 4 * width * height, stop);
  const size_t depths = with_depth_ ? width * height : 0;
  picture.depth.reserve(depths);
  resizeInPieces(picture.depth, depths, stop);
}

bool TiledPicture::shows(const TilePixels& pixels, float least_opacity) const {
  for (int y = 0; y < std::min(kTileSide, rows_.hi - pixels.y); ++y)
    for (int x = 0; x < std::min(kTileSide, size_.width - pixels.x); ++x)
      if (pixels.color[3][placeOf(x, y)] >= least_opacity) return true;
  return false;
}

void TiledPicture::copyTile(const TilePixels& pixels, Picture& picture) const {
  constexpr float kNothing = std::numeric_limits<float>::infinity();  // no depth, as in renderers
  const auto& [red, green, blue, opacity] = pixels.color;
  const int count = std::min(kTileSide, size_.width - pixels.x);
  for (int y = 0; y < std::min(kTileSide, rows_.hi - pixels.y); ++y) {
    const size_t to = placeIn(pixels, y);
    float* out = picture.rgba.data() + 4 * to;
    // No box was drawn into the tile.
    if (red == nullptr) {
      std::fill_n(out, 4 * count, start_);
      if (with_depth_) std::fill_n(picture.depth.data() + to, count, kNothing);
      continue;
    }
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
      picture.depth[to + static_cast<size_t>(x)] =
          // Depths were weighted by opacity.
          opacity[from] > 0 ? pixels.depth_sum[from] / opacity[from] : kNothing;
    }
  }
}

}  // namespace sluice
