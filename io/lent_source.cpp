#include "io/lent_source.h"

#include <fmt/format.h>

#include <cstring>
#include <utility>
#include <vector>

#include "io/files/copy_row.h"
#include "io/headers/volume_description.h"
#include "src/base/error.h"

namespace sluice {
namespace {

class LentSource final : public VolumeSource {
 public:
  LentSource(FillRegion fill, VolumeLayout layout)
      : fill_(std::move(fill)), layout_(std::move(layout)) {}

  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    fill_(time, box, out);
  }
  // No index of it is kept.
  std::string identity() const override { return layout_.name; }
  uint64_t storedBytesRead() const override { return 0; }

 private:
  const FillRegion fill_;
  const VolumeLayout layout_;
};

class LentBoxSource final : public VolumeSource {
 public:
  LentBoxSource(FillRegion fill, VolumeLayout layout, const Box3& there, Vec3i outside)
      : fill_(std::move(fill)),
        layout_(std::move(layout)),
        there_(there),
        voxel_(bytesPerVoxel(layout_.type)) {
    // Elsewhere in the volume, other ranks have the voxels: this one shows nothing there, whatever
    // value stands for them.
    const Vec3i at = outside - there_.lo;
    fill_(0, {at, at + Vec3i{1, 1, 1}}, voxel_);
    visitVoxelType(layout_.type, [&](auto tag) {
      std::memcpy(&tag, voxel_.data(), sizeof tag);
      outside_ = static_cast<double>(tag);
    });
  }

  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    const Box3 part = intersect(box, there_);
    if (part == box) return fill_(time, {box.lo - there_.lo, box.hi - there_.lo}, out);
    for (size_t at = 0; at < out.size(); at += voxel_.size())
      std::memcpy(out.data() + at, voxel_.data(), voxel_.size());
    if (part.empty()) return;
    std::vector<std::byte> voxels(static_cast<size_t>(part.count()) * voxel_.size());
    fill_(time, {part.lo - there_.lo, part.hi - there_.lo}, voxels);
    const Vec3i size = part.size(), whole = box.size(), at = part.lo - box.lo;
    const size_t row = static_cast<size_t>(size.x) * voxel_.size();
    const std::byte* from = voxels.data();
    for (int64_t z = 0; z < size.z; ++z)
      for (int64_t y = 0; y < size.y; ++y, from += row) {
        const int64_t to = ((at.z + z) * whole.y + at.y + y) * whole.x + at.x;
        std::memcpy(out.data() + static_cast<size_t>(to) * voxel_.size(), from, row);
      }
  }
  std::optional<Occupancy> occupancy(int64_t /*time*/) override {
    return Occupancy{outside_, {there_}};
  }
  std::string identity() const override { return layout_.name; }
  uint64_t storedBytesRead() const override { return 0; }

 private:
  const FillRegion fill_;
  const VolumeLayout layout_;
  const Box3 there_;
  std::vector<std::byte> voxel_;  // outside; constant after construction, as what follows
  double outside_ = 0;
};

}  // namespace

std::unique_ptr<VolumeSource> lentBoxSource(FillRegion fill, VolumeLayout layout, const Box3& there,
                                            Vec3i outside) {
  if (!fill) failRequest("{}: expected an array, found none", layout.name);
  return std::make_unique<LentBoxSource>(std::move(fill), std::move(layout), there, outside);
}

VolumeLayout lentLayout(VolumeLayout layout, const std::array<Vec3d, 3>& steps, Vec3d origin) {
  int64_t voxels = 1;
  for (const int64_t extent : {layout.dims.x, layout.dims.y, layout.dims.z, layout.time_steps})
    if (extent < 1 || __builtin_mul_overflow(voxels, extent, &voxels) || voxels > kMostVolumeVoxels)
      failRequest(
          "{}: expected dims and time steps of at least 1, and at most 2^59 voxels, found {} x {} "
          "x {} in {} steps",
          layout.name, layout.dims.x, layout.dims.y, layout.dims.z, layout.time_steps);
  setSteps(layout.name, {steps[0], steps[1], steps[2]}, layout);
  setOrigin(layout.name, origin, layout);
  return layout;
}

std::unique_ptr<VolumeSource> lentSource(FillRegion fill, VolumeLayout layout) {
  if (!fill) failRequest("{}: expected a function that gives voxels, found none", layout.name);
  return std::make_unique<LentSource>(std::move(fill), std::move(layout));
}

std::array<int64_t, 4> packedStrides(const VolumeLayout& layout) {
  const auto voxel = static_cast<int64_t>(bytesPerVoxel(layout.type));
  const Vec3i dims = layout.dims;
  return {voxel, voxel * dims.x, voxel * dims.x * dims.y, voxel * dims.x * dims.y * dims.z};
}

FillRegion fillFrom(const void* first, const VolumeLayout& layout,
                    const std::array<int64_t, 4>& strides) {
  if (first == nullptr) failRequest("{}: expected an array, found none", layout.name);
  const auto* voxels = static_cast<const std::byte*>(first);
  const size_t voxel_bytes = bytesPerVoxel(layout.type);
  return [=](int64_t time, const Box3& box, std::span<std::byte> out) {
    const int64_t width = box.size().x;
    std::byte* to = out.data();
    for (int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const std::byte* from =
            voxels + time * strides[3] + z * strides[2] + y * strides[1] + box.lo.x * strides[0];
        copyRow(from, strides[0], to, width, voxel_bytes);
        to += width * static_cast<int64_t>(voxel_bytes);
      }
  };
}

}  // namespace sluice
