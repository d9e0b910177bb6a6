#include "src/visibility/plenoptic/fusion.h"

#include <algorithm>
#include <array>

#include "src/base/error.h"

namespace sluice {
namespace {

// Sums side by side, which compilers turn into vector code; in double from block to block.
constexpr size_t kLanes = 8, kBatch = 1024;

}  // namespace

template <class T>
void fillOpacityBlock(const T* voxels, int64_t row_stride, int64_t plane_stride,
                      const PartGrid& grid, const ExtinctionTable& table, OpacityBlock& block) {
  block.parts = blockParts(voxels, row_stride, plane_stride, grid, table);
  const Vec3i size = grid.cells + Vec3i{1, 1, 1};
  block.opacity.resize(static_cast<size_t>(volume(size)));
  // Bytes have few values: each is looked up once.
  std::array<float, 256> known{};
  if constexpr (sizeof(T) == 1)
    for (size_t v = 0; v < known.size(); ++v) known[v] = table.opacityOf(static_cast<double>(v));
  float* to = block.opacity.data();
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const T* from = voxels + z * plane_stride + y * row_stride;
      for (int64_t x = 0; x < size.x; ++x) {
        if constexpr (sizeof(T) == 1)
          *to++ = known[from[x]];
        else
          *to++ = table.opacityOf(static_cast<double>(from[x]));
      }
    }
}

template void fillOpacityBlock(const uint8_t*, int64_t, int64_t, const PartGrid&,
                               const ExtinctionTable&, OpacityBlock&);
template void fillOpacityBlock(const uint16_t*, int64_t, int64_t, const PartGrid&,
                               const ExtinctionTable&, OpacityBlock&);
template void fillOpacityBlock(const float*, int64_t, int64_t, const PartGrid&,
                               const ExtinctionTable&, OpacityBlock&);

void fillUniform(double device, const PartGrid& grid, const ExtinctionTable& table,
                 OpacityBlock& block) {
  block.parts = uniformParts(device, grid, table);
  block.opacity.assign(static_cast<size_t>(volume(grid.cells + Vec3i{1, 1, 1})),
                       table.opacityOf(device));
}

double blockDifference(std::span<const float> a, std::span<const float> b) {
  SLUICE_CHECK_EQ(a.size(), b.size());
  double sum = 0;
  int64_t voxels = 0;
  for (size_t from = 0; from < a.size(); from += kBatch) {
    // A float sums at most kBatch / kLanes squares before they go to the double, so that little is
    // lost to rounding.
    const size_t end = std::min(a.size(), from + kBatch);
    std::array<float, kLanes> sums{};
    std::array<int32_t, kLanes> counts{};
    size_t i = from;
    for (; i + kLanes <= end; i += kLanes)
      for (size_t lane = 0; lane < kLanes; ++lane) {
        const float distance = a[i + lane] - b[i + lane];
        sums[lane] += distance * distance;
        // A voxel counts unless it is empty in both blocks (equation 2).
        counts[lane] += a[i + lane] + b[i + lane] > 0 ? 1 : 0;
      }
    for (; i < end; ++i) {
      const float distance = a[i] - b[i];
      sums[0] += distance * distance;
      counts[0] += a[i] + b[i] > 0 ? 1 : 0;
    }
    for (size_t lane = 0; lane < kLanes; ++lane) {
      sum += static_cast<double>(sums[lane]);
      voxels += counts[lane];
    }
  }
  return voxels == 0 ? 0 : sum / static_cast<double>(voxels);
}

void fuse(OpacityBlock& into, const OpacityBlock& by) {
  SLUICE_CHECK_EQ(into.opacity.size(), by.opacity.size());
  // The lower opacity of both hides no more than either step does (equation 3).
  const auto least = [](std::vector<float>& a, const std::vector<float>& b) {
    for (size_t i = 0; i < a.size(); ++i) a[i] = std::min(a[i], b[i]);
  };
  least(into.opacity, by.opacity);
  least(into.parts.least, by.parts.least);
}

}  // namespace sluice
