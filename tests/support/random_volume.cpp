#include "tests/support/random_volume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace sluice {
namespace {

// mt19937_64 is specified bit by bit; the library's distributions are not.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

template <class T>
constexpr double top() {
  return std::is_floating_point_v<T> ? 1.0 : static_cast<double>(std::numeric_limits<T>::max());
}

struct Blob {
  Vec3d center, drift;
  double radius;
};

}  // namespace

std::unique_ptr<MemorySource> makeSparseBlobs(const BlobOptions& options) {
  std::mt19937_64 random(options.seed);
  std::vector<Blob> blobs(static_cast<size_t>(options.blobs));
  for (Blob& blob : blobs) {
    for (int a = 0; a < 3; ++a) {
      blob.center[a] = uniform(random) * static_cast<double>(options.dims[a]);
      blob.drift[a] = (2 * uniform(random) - 1) * options.drift_vox / std::sqrt(3.0);
    }
    blob.radius = options.radius_vox * (0.5 + 0.5 * uniform(random));
  }
  VolumeLayout layout;
  layout.dims = options.dims;
  layout.spacing = options.spacing;
  layout.time_steps = options.time_steps;
  return visitVoxelType(options.type, [&](auto tag) {
    using T = decltype(tag);
    return makeMemorySource<T>(layout, [&](int64_t x, int64_t y, int64_t z, int64_t t) {
      double value = 0;
      for (const Blob& blob : blobs) {
        const Vec3d center = blob.center + blob.drift * static_cast<double>(t);
        const double r = length(toDouble({x, y, z}) - center) / blob.radius;
        value = std::max(value, 1 - r * r);
      }
      return static_cast<T>(value * 200 / 255 * top<T>());
    });
  });
}

std::unique_ptr<MemorySource> makeWhiteNoise(Vec3i dims, VoxelType type, uint64_t seed) {
  std::mt19937_64 random(seed);
  return visitVoxelType(type, [&](auto tag) {
    using T = decltype(tag);
    return makeMemorySource<T>(dims, [&](int64_t, int64_t, int64_t) {
      if constexpr (std::is_floating_point_v<T>)
        return static_cast<T>(uniform(random));
      else
        return static_cast<T>(random() >> 32);
    });
  });
}

}  // namespace sluice
