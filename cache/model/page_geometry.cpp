#include "cache/model/page_geometry.h"

#include <array>
#include <bit>
#include <charconv>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int64_t kMaxPageAxisVox = int64_t{1} << 20;

bool isPowerOfTwo(int64_t n) {
  return n > 0 && std::has_single_bit(static_cast<uint64_t>(n));
}

}  // namespace

Vec3i PageGeometry::pageGridOf(Vec3i chunk_vox) const {
  return {ceilDiv(chunk_vox.x, size_vox.x), ceilDiv(chunk_vox.y, size_vox.y),
          ceilDiv(chunk_vox.z, size_vox.z)};
}

void validate(const PageGeometry& geometry, std::string_view what) {
  for (int axis = 0; axis < 3; ++axis) {
    const int64_t n = geometry.size_vox[axis];
    if (!isPowerOfTwo(n) || n > kMaxPageAxisVox)
      fail("{}: a page's sides are powers of two from 1 to 2^20, found {}", what,
           printPageSize(geometry.size_vox));
  }
  if (geometry.bytes_per_voxel < 1 || geometry.bytes_per_voxel > 32)
    fail("{}: expected 1 to 32 bytes a voxel, found {}", what, geometry.bytes_per_voxel);
  if (geometry.pages < 1) fail("{}: expected at least one page, found {}", what, geometry.pages);
  // Sides to 2^20 and 32 bytes keep the first product within 63 bits, the second check the rest.
  const int64_t page_voxels = volume(geometry.size_vox);
  if (page_voxels > INT64_MAX / geometry.bytes_per_voxel / geometry.pages)
    fail("{}: {} pages of {} voxels are more than 2^63 bytes; take fewer or smaller pages", what,
         geometry.pages, printPageSize(geometry.size_vox));
}

std::optional<Vec3i> parsePageSize(std::string_view text) {
  Vec3i size;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size[axis]);
    if (error != std::errc() || !isPowerOfTwo(size[axis]) || size[axis] > kMaxPageAxisVox)
      return std::nullopt;
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    if (axis == 2) break;
    if (text.empty() || text.front() != 'x') return std::nullopt;
    text.remove_prefix(1);
  }
  if (!text.empty()) return std::nullopt;
  return size;
}

std::string printPageSize(Vec3i size_vox) {
  return fmt::format("{}x{}x{}", size_vox.x, size_vox.y, size_vox.z);
}

std::span<const PageConfiguration> pageConfigurations() {
  static constexpr std::array kAll{
      // SGI Octane/MXI of Tong 1999, section 4: pages of 32x64x2 voxels in 4 KiB, so a byte a
      // voxel;
      // a cache of 128x128x64 voxels, which is 256 pages. Assumed: any free page may take any part
      // of a chunk.
      PageConfiguration{"octane", {{32, 64, 2}, 1, 256}},
      // The same machine's texture memory of 4 MB. Assumed: all of it holds the volume. The paper's
      // cache is 1 MiB, and it does not say what the rest holds.
      PageConfiguration{"octane-4mb", {{32, 64, 2}, 1, 1024}},
      // The shapes of 64 KiB pages in the standard sparse block shapes of 3D images. Assumed: 64
      // MiB
      // of texture memory for the volume, since no standard says how much a driver keeps resident.
      PageConfiguration{"sparse-8", {{64, 32, 32}, 1, 1024}},
      PageConfiguration{"sparse-16", {{32, 32, 32}, 2, 1024}},
      PageConfiguration{"sparse-32", {{32, 32, 16}, 4, 1024}},
  };
  return kAll;
}

const PageConfiguration* findPageConfiguration(std::string_view name) {
  for (const PageConfiguration& c : pageConfigurations()) {
    if (c.name == name) return &c;
  }
  return nullptr;
}

}  // namespace sluice
