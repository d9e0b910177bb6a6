#include "io/slices/tiff/tiff_samples.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "io/files/luminance.h"

namespace sluice {

std::vector<uint8_t> paletteOf(TIFF* tiff, TiffStream& stream) {
  uint16_t *red = nullptr, *green = nullptr, *blue = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_COLORMAP, &red, &green, &blue) != 1)
    stream.failWith("TIFF with a palette that is missing");
  // Old writers put 8-bit numbers into fields for 16 bits.
  constexpr size_t kEntries = 256;
  uint16_t highest = 0;
  for (size_t i = 0; i < kEntries; ++i) highest = std::max({highest, red[i], green[i], blue[i]});
  std::vector<uint8_t> palette(kEntries);
  for (size_t i = 0; i < kEntries; ++i) {
    const uint16_t gray = luminance(red[i], green[i], blue[i]);
    palette[i] = static_cast<uint8_t>(highest < kEntries ? gray : gray >> 8);
  }
  return palette;
}

void convertPixels(const TiffPage& p, VoxelType type, std::span<const uint8_t> palette,
                   const std::byte* stored, std::span<std::byte> out, bool is_mirrored) {
  visitVoxelType(type, [&](auto tag) {
    using T = decltype(tag);
    for (int64_t x = 0; x < p.width; ++x) {
      T sample[3];
      std::memcpy(sample, stored + x * static_cast<int64_t>(p.pixelBytes()),
                  sizeof(T) * (p.hasColor() ? 3 : 1));
      T value = sample[0];
      if constexpr (std::is_same_v<T, uint8_t> || std::is_same_v<T, uint16_t>) {
        if (p.hasColor()) value = luminance(sample[0], sample[1], sample[2]);
        if (p.photometric == PHOTOMETRIC_PALETTE) value = palette[sample[0]];
      }
      if constexpr (std::is_unsigned_v<T>) {
        if (p.photometric == PHOTOMETRIC_MINISWHITE) value = static_cast<T>(~value);
      }
      const int64_t to = is_mirrored ? p.width - 1 - x : x;
      std::memcpy(out.data() + to * static_cast<int64_t>(sizeof(T)), &value, sizeof(T));
    }
  });
}

}  // namespace sluice
