#include "tests/support/memory_source.h"

#include "src/base/error.h"
#include "src/base/sources/region_check.h"

namespace sluice {
namespace {

std::string nextIdentity() {
  static std::atomic<int> made{0};
  return fmt::format("memory:{}", made++);
}

}  // namespace

MemorySource::MemorySource(VolumeLayout layout, std::vector<std::byte> voxels)
    : layout_(std::move(layout)), voxels_(std::move(voxels)), identity_(nextIdentity()) {
  SLUICE_CHECK_EQ(static_cast<int64_t>(voxels_.size()),
                  volume(layout_.dims) * layout_.time_steps *
                      static_cast<int64_t>(bytesPerVoxel(layout_.type)));
}

void MemorySource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  const Vec3i dims = layout_.dims;
  const auto voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout_.type));
  checkRegion(layout_, time, box, out);
  const auto row_bytes = static_cast<size_t>(box.size().x * voxel_bytes);
  std::byte* to = out.data();
  for (int64_t z = box.lo.z; z < box.hi.z; ++z)
    for (int64_t y = box.lo.y; y < box.hi.y; ++y, to += row_bytes) {
      const int64_t first = ((time * dims.z + z) * dims.y + y) * dims.x + box.lo.x;
      std::memcpy(to, voxels_.data() + first * voxel_bytes, row_bytes);
    }
  read_bytes_ += out.size();
}

}  // namespace sluice
