#include "tests/support/reference_renderer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <thread>

#include "src/base/error.h"

namespace sluice {
namespace {

// A time step's values, read by their position in voxels.
class Values {
 public:
  Values(VolumeSource& source, int64_t time) : layout_(source.layout()) {
    bytes_.resize(static_cast<size_t>(volume(layout_.dims)) * bytesPerVoxel(layout_.type));
    source.readRegion(time, boxOf(layout_.dims), bytes_);
    trilinear_ = visitVoxelType(layout_.type, [](auto tag) { return &trilinear<decltype(tag)>; });
  }

  // Trilinear between the eight voxels around p. Requires: 0 <= p[a] <= dims[a] - 1, dims >= 2.
  double at(Vec3d p) const {
    return trilinear_(bytes_.data(), layout_.dims, p) * layout_.value_scale + layout_.value_offset;
  }

 private:
  template <class T>
  static double trilinear(const std::byte* bytes, Vec3i dims, Vec3d p) {
    const auto* voxels = reinterpret_cast<const T*>(bytes);
    Vec3i i;
    Vec3d f;
    for (int a = 0; a < 3; ++a) {
      i[a] = std::min(static_cast<int64_t>(p[a]), dims[a] - 2);
      f[a] = p[a] - static_cast<double>(i[a]);
    }
    const auto voxel = [&](int64_t x, int64_t y, int64_t z) {
      return static_cast<double>(voxels[((i.z + z) * dims.y + i.y + y) * dims.x + i.x + x]);
    };
    const auto along_x = [&](int64_t y, int64_t z) {
      return voxel(0, y, z) * (1 - f.x) + voxel(1, y, z) * f.x;
    };
    const auto along_y = [&](int64_t z) { return along_x(0, z) * (1 - f.y) + along_x(1, z) * f.y; };
    return along_y(0) * (1 - f.z) + along_y(1) * f.z;
  }

  const VolumeLayout& layout_;
  std::vector<std::byte> bytes_;
  double (*trilinear_)(const std::byte*, Vec3i, Vec3d) = nullptr;
};

// index = rows * (world - origin): the inverse of VolumeLayout's map, which may be oblique.
struct IndexFromWorld {
  std::array<Vec3d, 3> rows;
  Vec3d origin;

  explicit IndexFromWorld(const VolumeLayout& layout) : origin(layout.origin) {
    const std::array<Vec3d, 3> e = {layout.axes[0] * layout.spacing.x,
                                    layout.axes[1] * layout.spacing.y,
                                    layout.axes[2] * layout.spacing.z};
    const double determinant = dot(e[0], cross(e[1], e[2]));
    rows = {cross(e[1], e[2]) / determinant, cross(e[2], e[0]) / determinant,
            cross(e[0], e[1]) / determinant};
  }
  Vec3d operator()(Vec3d world) const {
    const Vec3d d = world - origin;
    return {dot(rows[0], d), dot(rows[1], d), dot(rows[2], d)};
  }
};

// The depth of the corner that is farthest from the eye; no sample lies beyond.
double farthestDepth(const VolumeLayout& layout, const View& view) {
  double depth = -std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    Vec3d world = layout.origin;
    for (int a = 0; a < 3; ++a)
      if ((corner >> a & 1) != 0)
        world = world + layout.axes[static_cast<size_t>(a)] *
                            (layout.spacing[a] * static_cast<double>(layout.dims[a] - 1));
    depth = std::max(depth, dot(world - view.eye, view.forward));
  }
  return depth;
}

class Renderer {
 public:
  Renderer(VolumeSource& source, const View& view, const ReferenceScene& scene)
      : layout_(source.layout()),
        view_(view),
        scene_(scene),
        values_(source, scene.time),
        index_from_world_(layout_),
        crop_(scene.crop ? intersect(*scene.crop, boxOf(layout_.dims)) : boxOf(layout_.dims)),
        finest_(std::min({layout_.spacing.x, layout_.spacing.y, layout_.spacing.z})),
        last_depth_(farthestDepth(layout_, view)) {}

  struct Pixel {
    Vec3d rgb;
    double opacity = 0, depth = 0;
  };

  Pixel pixel(int i, int j) const {
    const double u = 2 * (i + 0.5) / view_.size.width - 1;
    const double v = 1 - 2 * (j + 0.5) / view_.size.height;
    const double aspect = static_cast<double>(view_.size.width) / view_.size.height;
    const Vec3d aside =
        view_.right * (u * aspect * view_.half_height) + view_.up * (v * view_.half_height);
    const bool ortho = view_.projection == Projection::kOrtho;
    const Vec3d start = ortho ? view_.eye + aside : view_.eye;
    const Vec3d direction = ortho ? view_.forward : view_.forward + aside;
    return scene_.mode == ReferenceMode::kComposite ? composite(start, direction)
                                                    : project(start, direction);
  }

 private:
  // Calls sample(position in voxels, depth) front to back until it returns false.
  template <class F>
  void eachSample(Vec3d start, Vec3d direction, F&& sample) const {
    for (int64_t k = 0;; ++k) {
      const double depth = view_.first_depth + (static_cast<double>(k) + 0.5) * view_.step;
      if (depth > last_depth_) return;
      if (depth <= 0 && view_.projection == Projection::kPerspective) continue;
      const Vec3d world = start + direction * depth;
      const Vec3d p = index_from_world_(world);
      if (counts(p, world) && !sample(p, depth)) return;
    }
  }

  bool counts(Vec3d p, Vec3d world) const {
    for (int a = 0; a < 3; ++a)
      if (!(p[a] >= static_cast<double>(crop_.lo[a]) &&
            p[a] < static_cast<double>(crop_.hi[a] - 1)))
        return false;
    return std::all_of(scene_.clip_planes.begin(), scene_.clip_planes.end(),
                       [&](const auto& plane) { return dot(plane.normal, world) <= plane.offset; });
  }

  Pixel composite(Vec3d start, Vec3d direction) const {
    const double voxel_lengths = view_.step * length(direction) / finest_;
    Pixel out;
    double depth_sum = 0;
    eachSample(start, direction, [&](Vec3d p, double depth) {
      const double value = values_.at(p);
      const double a = 1 - std::pow(1 - opacityAt(scene_.transfer, value), voxel_lengths);
      if (a > 0) {
        Vec3d rgb = colorAt(scene_.transfer, value);
        if (scene_.lighting) rgb = lit(p, rgb);
        const double weight = (1 - out.opacity) * a;
        out.rgb = out.rgb + rgb * weight;
        depth_sum += weight * depth;
        out.opacity += weight;
      }
      return out.opacity < scene_.opacity_threshold;
    });
    if (out.opacity > 0) out.depth = depth_sum / out.opacity;
    return out;
  }

  Pixel project(Vec3d start, Vec3d direction) const {
    double result = 0;
    int64_t taken = 0;
    eachSample(start, direction, [&](Vec3d p, double) {
      const double value = values_.at(p);
      if (opacityAt(scene_.transfer, value) > 0) {
        if (taken == 0)
          result = value;
        else if (scene_.mode == ReferenceMode::kMaximum)
          result = std::max(result, value);
        else if (scene_.mode == ReferenceMode::kMinimum)
          result = std::min(result, value);
        else
          result += value;
        ++taken;
      }
      return true;
    });
    if (taken == 0) return {};
    if (scene_.mode == ReferenceMode::kAverage) result /= static_cast<double>(taken);
    return {colorAt(scene_.transfer, result), 1, 0};
  }

  // Value units a world unit, in world directions.
  Vec3d gradient(Vec3d p) const {
    Vec3d g;
    for (int a = 0; a < 3; ++a) {
      Vec3d before = p, after = p;
      before[a] = std::max(p[a] - 1, 0.0);
      after[a] = std::min(p[a] + 1, static_cast<double>(layout_.dims[a] - 1));
      g = g + layout_.axes[static_cast<size_t>(a)] *
                  ((values_.at(after) - values_.at(before)) / (2 * layout_.spacing[a]));
    }
    return g;
  }

  Vec3d lit(Vec3d p, Vec3d rgb) const {
    const Lighting& lighting = *scene_.lighting;
    const Vec3d g = gradient(p);
    const double g2 = dot(g, g);
    if (g2 == 0) return rgb;
    const double flat =
        lighting.flat_share * (scene_.value_range.hi - scene_.value_range.lo) / finest_;
    const double w = g2 / (g2 + flat * flat);
    const Vec3d n = normalized(g);
    const Vec3d viewer = -view_.forward;
    double diffuse = 0, specular = 0;
    for (const Light& light : lighting.lights) {
      const Vec3d l =
          view_.right * light.toward.x + view_.up * light.toward.y + viewer * light.toward.z;
      diffuse += light.strength * std::abs(dot(n, l));
      specular +=
          light.strength * std::pow(std::abs(dot(n, normalized(l + viewer))), lighting.shininess);
    }
    const double shine = lighting.specular * specular;
    const Vec3d shown =
        rgb * (lighting.ambient + lighting.diffuse * diffuse) + Vec3d{shine, shine, shine};
    return rgb * (1 - w) + shown * w;
  }

  const VolumeLayout& layout_;
  const View& view_;
  const ReferenceScene& scene_;
  const Values values_;
  const IndexFromWorld index_from_world_;
  const Box3 crop_;
  const double finest_;
  const double last_depth_;
};

}  // namespace

FloatPicture renderReference(VolumeSource& source, const View& view, const ReferenceScene& scene) {
  const Renderer renderer(source, view, scene);
  FloatPicture picture;
  picture.width = view.size.width;
  picture.height = view.size.height;
  const size_t pixels = static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height);
  picture.rgba.resize(4 * pixels);
  picture.depth.resize(pixels);
  std::atomic<int> next_row{0};
  const auto work = [&] {
    for (int j = next_row++; j < picture.height; j = next_row++)
      for (int i = 0; i < picture.width; ++i) {
        const Renderer::Pixel pixel = renderer.pixel(i, j);
        const size_t at =
            static_cast<size_t>(j) * static_cast<size_t>(picture.width) + static_cast<size_t>(i);
        const Vec3d rgb = pixel.rgb;
        const std::array<double, 4> rgba = {rgb.x, rgb.y, rgb.z, pixel.opacity};
        for (size_t c = 0; c < 4; ++c) picture.rgba[4 * at + c] = static_cast<float>(rgba[c]);
        picture.depth[at] = static_cast<float>(pixel.depth);
      }
  };
  std::vector<std::jthread> threads;
  for (unsigned t = 1; t < std::max(1U, std::thread::hardware_concurrency()); ++t)
    threads.emplace_back(work);
  work();
  threads.clear();  // joins
  return picture;
}

}  // namespace sluice
