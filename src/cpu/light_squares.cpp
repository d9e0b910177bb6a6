#include "src/cpu/light_squares.h"

#include <algorithm>

namespace sluice {

void LightSquares::take(const LightVolumePtr& light, WorkerPool& pool) {
  if (of_ == light) return;
  of_ = light;
  if (light == nullptr || light->key_varies) {
    texels_ = {};
    return;
  }
  const Vec3i dims = light->dims;
  texels_.resize(static_cast<size_t>(volume(dims)));
  pool.parallelFor(dims.z, [&](int64_t z) {
    const auto numberAt = [&](int64_t x, int64_t y) {
      const int64_t texel =
          (z * dims.y + std::min(y, dims.y - 1)) * dims.x + std::min(x, dims.x - 1);
      return uint64_t{light->texels[2 * static_cast<size_t>(texel) + 1]};
    };
    for (int64_t y = 0; y < dims.y; ++y)
      for (int64_t x = 0; x < dims.x; ++x)
        texels_[static_cast<size_t>((z * dims.y + y) * dims.x + x)] =
            numberAt(x, y) | numberAt(x + 1, y) << 16 | numberAt(x, y + 1) << 32 |
            numberAt(x + 1, y + 1) << 48;
  });
}

}  // namespace sluice
