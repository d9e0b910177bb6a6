#include "src/view/state/screen/scaled_pixels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "src/base/error.h"

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little, "the bytes of a pixel as one number");

// The place of an output pixel along one axis: between `first` and `second`, of which it has
// `share` / 256.
struct Place {
  uint32_t first = 0, second = 0;
  uint32_t share = 0;
};

std::vector<Place> placesOf(int from, int to) {
  std::vector<Place> places(static_cast<size_t>(to));
  const double scale = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    // Pixels are sampled at their middles.
    const double at = std::clamp((i + 0.5) * scale - 0.5, 0.0, from - 1.0);
    const auto first = static_cast<uint32_t>(at);
    const auto last = static_cast<uint32_t>(from - 1);
    places[static_cast<size_t>(i)] = {
        first, std::min(first + 1, last),
        static_cast<uint32_t>(std::lround((at - static_cast<double>(first)) * 256))};
  }
  return places;
}

// Two of the four channels at once, each in a half of the number.
uint32_t between(uint32_t a, uint32_t b, uint32_t share) {
  // 255 * 256 + 128 fits into 16 bits, so a channel never carries into the one above it.
  constexpr uint32_t kEven = 0x00FF00FFU, kHalf = 0x00800080U;
  const uint32_t rest = 256 - share;
  const uint32_t even = (((a & kEven) * rest + (b & kEven) * share + kHalf) >> 8U) & kEven;
  const uint32_t odd = (((a >> 8U) & kEven) * rest + ((b >> 8U) & kEven) * share + kHalf) & ~kEven;
  return even | odd;
}

uint32_t blueFirst(uint32_t pixel) {
  return (pixel & 0xFF00FF00U) | ((pixel >> 16U) & 0xFFU) | ((pixel & 0xFFU) << 16U);
}

}  // namespace

void scalePixels(std::span<const uint8_t> rgba, int from_width, int from_height, int width,
                 int height, std::vector<uint32_t>& bgra) {
  const auto from_pixels = static_cast<size_t>(from_width) * static_cast<size_t>(from_height);
  SLUICE_CHECK_EQ(rgba.size(), from_pixels * 4);
  std::vector<uint32_t> from(from_pixels);
  std::memcpy(from.data(), rgba.data(), rgba.size());
  // The order is changed before scaling, since a preview has fewer pixels than the pane.
  for (uint32_t& pixel : from) pixel = blueFirst(pixel);
  if (from_width == width && from_height == height) {
    bgra.swap(from);
    return;
  }
  bgra.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
  const std::vector<Place> columns = placesOf(from_width, width);
  const std::vector<Place> rows = placesOf(from_height, height);
  std::vector<uint32_t> row(static_cast<size_t>(from_width));
  uint32_t* to = bgra.data();
  for (const Place& place : rows) {
    const uint32_t* const first = &from[place.first * static_cast<size_t>(from_width)];
    const uint32_t* const second = &from[place.second * static_cast<size_t>(from_width)];
    // Rows are mixed first, each once for the whole width, so that the inner loop over columns
    // reads one row.
    for (size_t x = 0; x < row.size(); ++x) row[x] = between(first[x], second[x], place.share);
    for (const Place& column : columns)
      *to++ = between(row[column.first], row[column.second], column.share);
  }
}

void mixPixels(std::span<const uint32_t> from, std::span<const uint32_t> to, double share,
               std::vector<uint32_t>& mixed) {
  SLUICE_CHECK_EQ(from.size(), to.size());
  const auto part = static_cast<uint32_t>(std::lround(256 * std::clamp(share, 0.0, 1.0)));
  mixed.resize(to.size());
  for (size_t i = 0; i < to.size(); ++i) mixed[i] = between(from[i], to[i], part);
}

}  // namespace sluice
