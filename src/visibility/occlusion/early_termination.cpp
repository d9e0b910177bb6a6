#include "src/visibility/occlusion/early_termination.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"
#include "src/base/threads/mutex.h"

namespace sluice {
namespace {

// Extinction of each entry, and of a device value between two.
class Curve {
 public:
  explicit Curve(const OpacityTable& table) : table_(table) {}
  double at(double device) const {
    // The stand-in for NaN, and all that interpolation makes of it, shows nothing.
    if (device < -2e38) return 0;
    const double opacity = table_.opacity()[static_cast<size_t>(table_.entryOf(device))];
    // An opaque sample ends any ray, whatever the threshold.
    return opacity >= 1 ? 1e3 : -std::log1p(-opacity);
  }

 private:
  const OpacityTable& table_;
};

template <class T>
double valueAt(const T* voxels, Vec3i dims, Vec3d p) {
  const Vec3i at{static_cast<int64_t>(p.x), static_cast<int64_t>(p.y), static_cast<int64_t>(p.z)};
  const double fx = p.x - static_cast<double>(at.x), fy = p.y - static_cast<double>(at.y),
               fz = p.z - static_cast<double>(at.z);
  const T* v = voxels + (at.z * dims.y + at.y) * dims.x + at.x;
  const int64_t row = dims.x, plane = dims.x * dims.y;
  const auto lerp = [](double a, double b, double f) { return a + (b - a) * f; };
  const auto line = [&](const T* from) {
    return lerp(static_cast<double>(from[0]), static_cast<double>(from[1]), fx);
  };
  return lerp(lerp(line(v), line(v + row), fy), lerp(line(v + plane), line(v + plane + row), fy),
              fz);
}

struct Stretch {
  double from, to;
};
Stretch insideVolume(Vec3d origin, Vec3d step, Vec3i dims) {
  Stretch u{-1e15, 1e15};
  for (int a = 0; a < 3; ++a) {
    const double most = static_cast<double>(dims[a] - 1);
    if (step[a] == 0) {
      // Half-open: a sample on the volume's last plane belongs to no cell.
      if (origin[a] < 0 || origin[a] >= most) return {0, -1};
      continue;
    }
    const auto [near, far] = std::minmax({(0 - origin[a]) / step[a], (most - origin[a]) / step[a]});
    u = {std::max(u.from, near), std::min(u.to, far)};
  }
  return u;
}

}  // namespace

std::vector<bool> reachedByRays(const WholeStep& step, int64_t block_cells,
                                const OpacityTable& table, const EstimateView& view,
                                double opacity_threshold, WorkerPool& pool) {
  const Vec3i dims = step.dims;
  SLUICE_CHECK_EQ(step.voxels.size(), static_cast<size_t>(volume(dims)) * bytesPerVoxel(step.type));
  const Vec3i grid{ceilDiv(dims.x - 1, block_cells), ceilDiv(dims.y - 1, block_cells),
                   ceilDiv(dims.z - 1, block_cells)};
  // A threshold of 1 ends no ray.
  const double limit = opacity_threshold >= 1 ? 1e300 : -std::log1p(-opacity_threshold);
  const Curve curve(table);
  Mutex mutex;
  std::vector<bool> reached(static_cast<size_t>(volume(grid)), false);
  pool.parallelFor(view.size.height, [&](int64_t y) {
    // A list for each row of pixels, so that threads share nothing while they look at rays.
    std::vector<bool> mine(reached.size(), false);
    visitDeviceType(step.type, [&](auto tag) {
      const auto* voxels = reinterpret_cast<const decltype(tag)*>(step.voxels.data());
      const double py = static_cast<double>(y) + 0.5;
      for (int x = 0; x < view.size.width; ++x) {
        const double px = x + 0.5;
        const Vec3d origin =
            view.rays.origin0 + view.rays.origin_dx * px + view.rays.origin_dy * py;
        const Vec3d way = view.rays.step0 + view.rays.step_dx * px + view.rays.step_dy * py;
        // Unit lengths from sample to sample: further apart away from a perspective view's middle.
        double length_vox = view.slice_length;
        if (!view.parallel) {
          const double u = (2 * px / view.size.width - 1) * view.tan_half[0];
          const double v = (2 * py / view.size.height - 1) * view.tan_half[1];
          length_vox *= std::sqrt(1 + u * u + v * v);
        }
        const Stretch inside = insideVolume(origin, way, dims);
        double sum = 0;
        int64_t last = -1;
        for (auto k =
                 static_cast<int64_t>(std::max(view.first_slice, std::ceil(inside.from - 0.5)));
             static_cast<double>(k) + 0.5 < inside.to; ++k) {
          const Vec3d p = origin + way * (static_cast<double>(k) + 0.5);
          // The stretch is rounded: its first and last samples may lie just outside.
          if (p.x < 0 || p.y < 0 || p.z < 0 || p.x >= static_cast<double>(dims.x - 1) ||
              p.y >= static_cast<double>(dims.y - 1) || p.z >= static_cast<double>(dims.z - 1))
            continue;
          const int64_t block = (static_cast<int64_t>(p.z) / block_cells * grid.y +
                                 static_cast<int64_t>(p.y) / block_cells) *
                                    grid.x +
                                static_cast<int64_t>(p.x) / block_cells;
          if (block != last) {
            // A ray that is opaque reaches no further block. Within a block it may become opaque on
            // the way.
            if (sum >= limit) break;
            mine[static_cast<size_t>(block)] = true;
            last = block;
          }
          sum += curve.at(valueAt(voxels, dims, p)) * length_vox;
        }
      }
    });
    const MutexLock lock(mutex);
    for (size_t i = 0; i < mine.size(); ++i)
      if (mine[i]) reached[i] = true;
  });
  return reached;
}

}  // namespace sluice
