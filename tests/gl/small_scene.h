// The smallest drawings that show a context works: an own framebuffer object, one program, one
// triangle, read back. The context must be current.
#pragma once

#include <array>
#include <vector>

#include "src/gl/contexts/context.h"

namespace sluice {

using Rgba = std::array<float, 4>;
inline constexpr int kSceneSize = 8;  // pixels along both axes

// Row by row from the bottom: `clear` everywhere, then `color` if x + y < kSceneSize - 1 (the
// diagonal belongs to either).
std::vector<Rgba> drawTriangle(const GlContext& context, Rgba clear, Rgba color);

// The red channel along x of a 3D texture of 2x2x2 8-bit texels, `left` at x = 0 and `right` at x =
// 1, sampled linearly at (i + 1/2) / count; times 255.
std::vector<float> sampleAcross(const GlContext& context, unsigned char left, unsigned char right,
                                int count);

}  // namespace sluice
