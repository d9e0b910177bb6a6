#include "src/library/opening/thick_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_times.h"

namespace sluice {
namespace {

constexpr Vec3i kTwo{2, 2, 2};

VolumeLayout thickLayout(VolumeLayout layout) {
  std::string axes;
  for (int a = 0; a < 3; ++a) {
    if (layout.dims[a] > 1) continue;
    // Half a voxel to either side, so that the plane keeps its place.
    layout.origin = layout.origin - layout.axes[static_cast<size_t>(a)] * (0.5 * layout.spacing[a]);
    axes += fmt::format("{}{}", axes.empty() ? "" : ", ", "xyz"[a]);
  }
  layout.notes.push_back(
      fmt::format("{}: one voxel along {}, drawn one voxel thick", layout.calledBy(), axes));
  layout.dims = max(layout.dims, kTwo);
  return layout;
}

class ThickSource : public VolumeSource, public ChanneledSource, public TimedSource {
 public:
  explicit ThickSource(std::unique_ptr<VolumeSource> thin)
      : thin_(std::move(thin)), layout_(thickLayout(thin_->layout())) {}

  const VolumeLayout& layout() const override { return layout_; }
  std::span<const std::string> channelNames() const override {
    return sluice::channelNames(*thin_);
  }
  std::span<const StoredLook> channelLooks() const override { return sluice::channelLooks(*thin_); }
  std::optional<TimeAxis> times() const override { return timesOf(*thin_); }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    // Both planes are the one.
    const Vec3i dims = thin_->layout().dims;
    // Both ends are brought to the one plane; the box keeps it, since its upper end is 1 or more.
    const Box3 stored{min(box.lo, dims - Vec3i{1, 1, 1}), min(box.hi, dims)};
    const size_t bytes = bytesPerVoxel(layout_.type);
    std::vector<std::byte> voxels(static_cast<size_t>(stored.count()) * bytes);
    thin_->readRegion(time, stored, voxels);
    const Vec3i size = stored.size();
    std::byte* to = out.data();
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (int64_t x = box.lo.x; x < box.hi.x; ++x, to += bytes) {
          const Vec3i at = min(Vec3i{x, y, z}, dims - Vec3i{1, 1, 1}) - stored.lo;
          const auto index = static_cast<size_t>((at.z * size.y + at.y) * size.x + at.x);
          std::memcpy(to, voxels.data() + index * bytes, bytes);
        }
  }

  std::optional<Occupancy> occupancy(int64_t time) override {
    std::optional<Occupancy> found = thin_->occupancy(time);
    if (!found) return found;
    for (Box3& box : found->boxes)
      for (int a = 0; a < 3; ++a)
        // The occupied plane is both planes.
        if (thin_->layout().dims[a] == 1 && !box.empty()) box.hi[a] = 2;
    return found;
  }

  std::string identity() const override { return thin_->identity() + " one voxel thick"; }
  std::vector<std::string> files() override { return thin_->files(); }
  uint64_t heldBytesAThread() const override { return thin_->heldBytesAThread(); }
  void holdAtMost(uint64_t bytes) override { thin_->holdAtMost(bytes); }
  int distantReads() const override { return thin_->distantReads(); }
  uint64_t storedBytesRead() const override { return thin_->storedBytesRead(); }
  const VolumeLayout& storedLayout() const { return thin_->layout(); }

 private:
  const std::unique_ptr<VolumeSource> thin_;
  const VolumeLayout layout_;
};

}  // namespace

std::unique_ptr<VolumeSource> withThickness(std::unique_ptr<VolumeSource> source) {
  const Vec3i dims = source->layout().dims;
  if (dims.x > 1 && dims.y > 1 && dims.z > 1) return source;
  return std::make_unique<ThickSource>(std::move(source));
}

const VolumeLayout& storedLayout(const VolumeSource& source) {
  const auto* thick = dynamic_cast<const ThickSource*>(&source);
  return thick != nullptr ? thick->storedLayout() : source.layout();
}

}  // namespace sluice
