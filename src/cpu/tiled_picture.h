// TiledPicture: the pixels of a frame as the kernels keep them, a tile after another, each packet
// by packet; and the conversion to pictures.
//
// Different tiles may be begun, drawn and read by different threads at once. All else: one thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/base/values/picture.h"
#include "src/cpu/kernels/kernel_values.h"
#include "src/device/pictures/picture_rows.h"

namespace sluice {

static_assert(kRowStep % kTileSide == 0);

class TiledPicture {
 public:
  // A tile's: colours, stopped, depth.
  static constexpr size_t kMostFloats = size_t{6} * kTilePixels;

  // Begins an empty picture with its pixels placed as `kernels` want them. `rows`: the rows of the
  // frame's picture that are kept, from a multiple of kTileSide on.
  void begin(const FrameSetup& setup, const Kernels& kernels, PictureRows rows);

  int tilesAcross() const { return across_; }
  int tilesUp() const { return up_; }
  int lowestTiles() const { return rows_.lo / kTileSide; }  // row of tiles in the frame's picture
  int64_t tiles() const { return int64_t{across_} * up_; }
  // Memory for the pixels. A picture that is drawn in one go needs none.
  void makeRoom();
  // A tile to draw on, emptied when it is asked for first, by the thread that draws on it.
  // Requires: there is room.
  TilePixels tile(int64_t index);
  // The same for the last time: of a tile that was not begun the pixels are in `scratch` alone,
  // which stays in the processor's first cache.
  struct Scratch {
    alignas(64) std::array<float, kMostFloats> floats;
  };
  TilePixels tile(int64_t index, Scratch& scratch);
  // The tile if it was begun, otherwise one without pixels.
  TilePixels drawnTile(int64_t index) const;
  // The index of a tile's pixel in its arrays, x and y counted from its lower left.
  size_t placeOf(int x, int y) const {
    const int pixel = y * kTileSide + x;
    return static_cast<size_t>(place_[static_cast<size_t>(pixel)]);
  }

  // Pixels that have this opacity now take no more samples. Each tile learns of it when it is asked
  // for next, before it is drawn on.
  void stopOpaque(float opacity);
  // Gives `picture` the width of this one and the height of its rows. Clearing gigabytes takes
  // seconds: throws Interrupted on the way.
  void shape(Picture& picture, const StopToken& stop = {}) const;
  // Copies a tile's pixels, if it has some, into a picture of that shape: premultiplied, rows
  // downwards; depths if it has them.
  void copyTile(const TilePixels& pixels, Picture& picture) const;
  // Whether a pixel of the picture has this opacity in a tile that was drawn.
  bool shows(const TilePixels& pixels, float least_opacity) const;
  // Visits the place of each row of the tile's pixels in such a picture: rgba.
  template <class F>
  void eachRow(const TilePixels& pixels, Picture& picture, F&& visit) const {
    const auto count = static_cast<size_t>(std::min(kTileSide, size_.width - pixels.x));
    for (int y = 0; y < std::min(kTileSide, rows_.hi - pixels.y); ++y)
      visit(std::span(picture.rgba).subspan(4 * placeIn(pixels, y), 4 * count));
  }

 private:
  static constexpr int32_t kNotBegun = -1;

  // The tile with its arrays from `floats` on, if there are some.
  TilePixels tileAt(int64_t index, float* floats) const;
  void empty(const TilePixels& pixels) const;
  // The index in a picture of the leftmost pixel of a tile's row.
  size_t placeIn(const TilePixels& pixels, int y) const {
    const auto width = static_cast<size_t>(size_.width);
    return static_cast<size_t>(rows_.hi - 1 - pixels.y - y) * width + static_cast<size_t>(pixels.x);
  }
  float* floatsOf(int64_t index) const {
    return pixels_ + static_cast<size_t>(index) * floatsATile();
  }
  // Floats per tile, and the begin of each array among them.
  size_t floatsATile() const { return arrays_ * kTilePixels; }

  // Kernels::placeOf() of each pixel of a tile, row after row.
  std::array<int, kTilePixels> place_{};
  PictureSize size_{0, 0};  // size of the frame's picture
  PictureRows rows_;        // the rows of it that are kept
  int across_ = 0, up_ = 0;
  size_t arrays_ = 0;
  bool with_depth_ = false;
  float start_ = 0;  // colours before anything is drawn
  float stop_opacity_ = 1;
  int32_t stop_number_ = 0;     // counts stopOpaque()
  std::vector<int32_t> stops_;  // for each tile, the last stopOpaque() that it knows of
  // Aligned by hand, and not cleared: a tile is emptied when it is asked for.
  std::unique_ptr<float[]> memory_;
  size_t memory_floats_ = 0;
  float* pixels_ = nullptr;
};

}  // namespace sluice
