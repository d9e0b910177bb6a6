#include "io/synth/mean_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "src/base/error.h"

namespace sluice {
namespace {

// The mean of `count` values whose sum is `sum`; halves are rounded up.
template <class T, class Sum>
T meanOf(Sum sum, Sum count) {
  if constexpr (std::is_floating_point_v<T>) return static_cast<T>(sum / count);
  return static_cast<T>((2 * sum + count) / (2 * count));
}

// Of `count` values that sum up to `sum`, and their squares to `squares`.
template <class T>
T spreadOf(double sum, double squares, double count) {
  const double mean = sum / count;
  const double spread = 2 * std::sqrt(std::max(0.0, squares / count - mean * mean));
  return static_cast<T>(std::is_floating_point_v<T> ? spread : std::nearbyint(spread));
}

enum class Delivers { kMeans, kSpreads };

class MeanLevel final : public VolumeSource {
 public:
  MeanLevel(VolumeSource& finest, int64_t times, Delivers delivers)
      : finest_(finest), times_(times), delivers_(delivers) {
    layout_ = finest.layout();
    layout_.dims = layout_.dims / times;
    // The mean of the first voxels lies in the middle of them.
    const double shift = static_cast<double>(times - 1) / 2;
    for (int a = 0; a < 3; ++a)
      layout_.origin =
          layout_.origin + layout_.axes[static_cast<size_t>(a)] * (layout_.spacing[a] * shift);
    layout_.spacing = layout_.spacing * static_cast<double>(times);
    // Means and spreads do not fill the range that the finest voxels have.
    layout_.stored_range.reset();
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override {
    const char* const what = delivers_ == Delivers::kMeans ? "mean" : "spread";
    return fmt::format("{},{}={}", finest_.identity(), what, times_);
  }
  uint64_t storedBytesRead() const override { return 0; }  // counted by the source of the voxels

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    switch (layout_.type) {
      case VoxelType::kU8:
        return readTyped<uint8_t, uint64_t>(time, box, out);
      case VoxelType::kU16:
        return readTyped<uint16_t, uint64_t>(time, box, out);
      case VoxelType::kF32:
        return readTyped<float, double>(time, box, out);
      default:
        fail("{}: levels of resolution exist only for u8, u16 and f32", layout_.name);
    }
  }

 private:
  // A row of the level after the other.
  template <class T, class Sum>
  void readTyped(int64_t time, const Box3& box, std::span<std::byte> out) {
    const int64_t width = box.size().x;
    const Vec3i cube{times_, times_, times_};
    // One row of the level is 'times' squared rows of voxels: memory does not grow with the region.
    std::vector<T> finest(static_cast<size_t>(width * volume(cube)));
    std::vector<Sum> sums(static_cast<size_t>(width));
    std::vector<double> squares(sums.size());
    std::byte* to = out.data();
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const Vec3i first{box.lo.x, y, z};
        const Box3 from{first * cube, Vec3i{box.hi.x, y + 1, z + 1} * cube};
        finest_.readRegion(time, from, std::as_writable_bytes(std::span(finest)));
        std::ranges::fill(sums, Sum{});
        std::ranges::fill(squares, 0.0);
        const T* voxel = finest.data();
        for (int64_t row = 0; row < times_ * times_; ++row)
          for (int64_t x = 0; x < width; ++x)
            for (int64_t i = 0; i < times_; ++i, ++voxel) {
              const auto value = static_cast<double>(*voxel);
              sums[static_cast<size_t>(x)] += static_cast<Sum>(*voxel);
              squares[static_cast<size_t>(x)] += value * value;
            }
        for (size_t x = 0; x < sums.size(); ++x) {
          const int64_t count = volume(cube);
          const T number = delivers_ == Delivers::kMeans
                               ? meanOf<T>(sums[x], static_cast<Sum>(count))
                               : spreadOf<T>(static_cast<double>(sums[x]), squares[x],
                                             static_cast<double>(count));
          std::memcpy(to, &number, sizeof number);
          to += sizeof number;
        }
      }
  }

  VolumeSource& finest_;
  const int64_t times_;
  const Delivers delivers_;
  VolumeLayout layout_;  // constant after construction
};

}  // namespace

MeanLevels::MeanLevels(VolumeSource& finest, int64_t count, Spreads spreads) {
  const VolumeLayout& layout = finest.layout();
  int64_t times = 1;
  for (int64_t level = 1; level < count; ++level) {
    times *= 2;
    const Vec3i dims = layout.dims / times;
    if (dims.x < 2 || dims.y < 2 || dims.z < 2)
      fail("{}: {} x {} x {} voxels have {} levels of at least 2 voxels along each axis, not {}",
           layout.name, layout.dims.x, layout.dims.y, layout.dims.z, level, count);
    const auto add = [&](Delivers delivers) {
      sources_.push_back(std::make_unique<MeanLevel>(finest, times, delivers));
      return sources_.back().get();
    };
    const double scale = static_cast<double>(times), offset = (scale - 1) / 2;
    levels_.push_back({add(Delivers::kMeans),
                       {{scale, scale, scale}, {offset, offset, offset}},
                       spreads == Spreads::kKept ? add(Delivers::kSpreads) : nullptr,
                       true,
                       LevelValues::kMeans});
  }
}

}  // namespace sluice
