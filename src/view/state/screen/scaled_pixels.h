// Pixels of one size as pixels of another, for windows that the processor draws: smooth, as a
// texture unit filters them (values lie at the middles of pixels, and edges are extended).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sluice {

// Makes width * height pixels, packed, rows from the top, of `from_width` * `from_height` * 4
// bytes, red first. Each comes as blue, green, red, alpha in memory: the order that screens have.
// Exact to 1.5 / 255 a channel; of the same size exact.
void scalePixels(std::span<const uint8_t> rgba, int from_width, int from_height, int width,
                 int height, std::vector<uint32_t>& bgra);

// Makes the pixels between two pictures of one size, in the same order as theirs: `share` of `to`,
// 0 to 1, and the rest of `from`; at 1 exactly `to`. Exact to 1.5 / 255 a channel.
void mixPixels(std::span<const uint32_t> from, std::span<const uint32_t> to, double share,
               std::vector<uint32_t>& mixed);

}  // namespace sluice
