#include "src/library/drawing/scene/added_pictures.h"

#include <algorithm>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kNumbers = 4;  // of a pixel
constexpr int64_t kPixelsAtOnce = int64_t{1} << 16;

// Calls `body` with ranges of pixels, on all threads.
template <class Body>
void eachPixels(const Picture& picture, WorkerPool& pool, const Body& body) {
  const auto pixels = static_cast<int64_t>(picture.rgba.size() / kNumbers);
  pool.parallelFor((pixels + kPixelsAtOnce - 1) / kPixelsAtOnce, [&](int64_t part) {
    body(static_cast<size_t>(part * kPixelsAtOnce),
         static_cast<size_t>(std::min(pixels, (part + 1) * kPixelsAtOnce)));
  });
}

// The mean weighted by the opacities. The depth of an empty pixel is infinite and has no weight.
float meanDepth(float opacity, float depth, float more_opacity, float more_depth) {
  if (!(more_opacity > 0)) return depth;
  if (!(opacity > 0)) return more_depth;
  return (opacity * depth + more_opacity * more_depth) / (opacity + more_opacity);
}

}  // namespace

void addPicture(Picture& sum, const Picture& more, WorkerPool& pool) {
  SLUICE_CHECK_EQ(sum.rgba.size(), more.rgba.size());
  SLUICE_CHECK_EQ(sum.depth.size(), more.depth.size());
  eachPixels(sum, pool, [&](size_t begin, size_t end) {
    // Before the colours: the weights are the opacities before the sum.
    if (!sum.depth.empty())
      for (size_t i = begin; i < end; ++i)
        sum.depth[i] = meanDepth(sum.rgba[kNumbers * i + 3], sum.depth[i],
                                 more.rgba[kNumbers * i + 3], more.depth[i]);
    for (size_t i = kNumbers * begin; i < kNumbers * end; ++i) sum.rgba[i] += more.rgba[i];
  });
}

void limitSum(Picture& sum, WorkerPool& pool) {
  eachPixels(sum, pool, [&](size_t begin, size_t end) {
    for (size_t i = kNumbers * begin; i < kNumbers * end; ++i)
      sum.rgba[i] = std::min(sum.rgba[i], 1.0F);
  });
}

}  // namespace sluice
