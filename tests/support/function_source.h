// FunctionSource: a VolumeSource whose voxels are computed, so that a test can have a volume of any
// size, sparse ones too.
//
// Constant after construction but for the byte count; any thread may read, if `value` lets it.
#pragma once

#include <atomic>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "src/base/error.h"
#include "src/base/sources/region_check.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// A layout of this size and voxel type, for a FunctionSource.
inline VolumeLayout functionLayout(Vec3i dims, VoxelType type) {
  VolumeLayout layout;
  layout.dims = dims;
  layout.type = type;
  layout.name = "function";
  return layout;
}

class FunctionSource : public VolumeSource {
 public:
  // The stored value of a voxel at a time step.
  using Value = std::function<double(int64_t time, Vec3i voxel)>;

  FunctionSource(VolumeLayout layout, Value value,
                 std::optional<Occupancy> occupancy = std::nullopt)
      : layout_(std::move(layout)), value_(std::move(value)), occupancy_(std::move(occupancy)) {}

  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    checkRegion(layout_, time, box, out);
    visitVoxelType(layout_.type, [&](auto tag) {
      std::byte* to = out.data();
      for (int64_t z = box.lo.z; z < box.hi.z; ++z)
        for (int64_t y = box.lo.y; y < box.hi.y; ++y)
          for (int64_t x = box.lo.x; x < box.hi.x; ++x, to += sizeof tag) {
            const auto voxel = static_cast<decltype(tag)>(value_(time, {x, y, z}));
            std::memcpy(to, &voxel, sizeof voxel);
          }
    });
    read_bytes_ += out.size();
  }
  std::optional<Occupancy> occupancy(int64_t /*time*/) override { return occupancy_; }
  std::string identity() const override { return "function:" + layout_.name; }
  uint64_t storedBytesRead() const override { return read_bytes_; }

 private:
  const VolumeLayout layout_;
  const Value value_;
  const std::optional<Occupancy> occupancy_;
  std::atomic<uint64_t> read_bytes_{0};
};

}  // namespace sluice
