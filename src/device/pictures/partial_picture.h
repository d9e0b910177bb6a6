// PartialPicture: the picture of some boxes, while other devices or ranks draw the rest. It is
// packed: only pixels that show something, layer by layer, tile by tile.
//
// The folder: parts and rows of a picture, pictures on a screen (screen_picture.h), and numbers of
// their pixels (depth_code.h, blue_noise.h).
//
// A layer is a set of boxes none of which hides another. Layers are numbered front to back, alike
// on all devices that draw parts of the picture, so that blending the parts in the order of layers
// is exact however the boxes interleave. Modes that need no order have one layer.
//
// A tile consists of records, each for one layer: the layer's number, a mask of its pixels, and
// their numbers. Composite: red, green, blue, opacity, premultiplied, and with depth the sum of
// weights times depths; other modes the two or three numbers of resolveMode(), for a unit of 1.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

// Tiles are kPartSide x kPartSide pixels; pixel i of one is (i % kPartSide, i / kPartSide) from its
// lower left corner.
inline constexpr int kPartSide = 16;
inline constexpr int kPartPixels = kPartSide * kPartSide;

// Numbers of a pixel.
inline int partChannels(const FrameSetup& setup) {
  const ModeTraits& traits = traitsOf(setup.mode);
  if (!traits.has_colors) return traits.combining == Combining::kAttenuated ? 3 : 2;
  return setup.with_depth ? 5 : 4;
}
inline constexpr int kMostPartChannels = 5;

struct PartialPicture {
  int across = 0, up = 0;                     // tiles
  std::vector<std::vector<std::byte>> tiles;  // records; row after row from the lower left tile

  // Memory in bytes.
  uint64_t bytes() const;
};
// Throws Error if `bytes` of parts exceed the limit.
void checkPartRoom(uint64_t bytes, uint64_t most_bytes);
PartialPicture emptyPartialPicture(PictureSize size);

// A tile's memory is at most this share of its records more than they take.
inline constexpr size_t kPartGrowth = 4;
struct PartHeader {
  uint32_t layer = 0;
  uint32_t pixels = 0;  // in the mask
  std::array<uint64_t, kPartPixels / 64> mask{};
};

// Appends a record if `isShown(pixel)` is true of any pixel; `numberOf(pixel, channel)` are its
// numbers.
template <class IsShown, class NumberOf>
void packPart(std::vector<std::byte>& to, uint32_t layer, int channels, const IsShown& isShown,
              const NumberOf& numberOf) {
  PartHeader header{layer, 0, {}};
  for (int i = 0; i < kPartPixels; ++i) {
    const uint64_t shown = isShown(i) ? 1 : 0;
    header.mask[static_cast<size_t>(i / 64)] |= shown << (i % 64);
    header.pixels += static_cast<uint32_t>(shown);
  }
  if (header.pixels == 0) return;
  const size_t at = to.size();
  const size_t size =
      at + sizeof header + header.pixels * static_cast<size_t>(channels) * sizeof(float);
  // Grown in smaller steps than a vector's own, since all memory of parts is counted.
  if (size > to.capacity()) to.reserve(size + at / kPartGrowth);
  to.resize(size);
  std::memcpy(to.data() + at, &header, sizeof header);
  std::byte* out = to.data() + at + sizeof header;
  for (size_t word = 0; word < header.mask.size(); ++word)
    for (uint64_t left = header.mask[word]; left != 0; left &= left - 1) {
      const int pixel = static_cast<int>(word * 64) + std::countr_zero(left);
      for (int channel = 0; channel < channels; ++channel, out += sizeof(float)) {
        const float number = numberOf(pixel, channel);
        std::memcpy(out, &number, sizeof number);
      }
    }
}

// A record as it lies in memory.
struct PartRecord {
  PartHeader header;
  std::span<const std::byte> numbers;  // header.pixels * channels floats
};
// The records of a tile, in the order in which they were appended. Throws Error if they are cut
// off.
std::vector<PartRecord> partRecords(std::span<const std::byte> tile, int channels);

// The numbers of a tile's pixels, channel after channel, of records that are put together.
using TileNumbers = std::array<std::array<float, kPartPixels>, kMostPartChannels>;

// Composes the parts of one tile: `records` may come in any order that keeps records of one layer
// and one maker in theirs.
TileNumbers composeTile(std::vector<PartRecord> records, const FrameSetup& setup);

}  // namespace sluice
