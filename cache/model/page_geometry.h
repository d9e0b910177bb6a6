// PageGeometry: how texture memory is cut into pages (Tong, section 3.1), and the named machines.
//
// A page is the smallest unit that moves into the texture cache: 2^a x 2^b x 2^c voxels of b bytes.
// The cache holds 2^k of them. A chunk occupies whole pages: each of its axes is rounded up to
// pages, which is the page rounding that the reports show. Start here to read `cache/`:
//   page_geometry.h -> policy.h -> texture_cache.h (decides) -> trace.h -> simulator.h (replays)
// Plain values, safe from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "src/base/values/vec.h"

namespace sluice {

struct PageGeometry {
  Vec3i size_vox{32, 64, 2};    // voxels, each a power of two
  int64_t bytes_per_voxel = 1;  // bytes of a voxel in texture memory
  int64_t pages = 256;          // how many are resident at most; a power of two

  int64_t pageBytes() const { return volume(size_vox) * bytes_per_voxel; }
  int64_t cacheBytes() const { return pageBytes() * pages; }
  // Pages along each axis that a chunk of `chunk_vox` voxels takes. Requires: chunk_vox >= 0.
  Vec3i pageGridOf(Vec3i chunk_vox) const;
  // Their number. 0 for an empty chunk.
  int64_t pagesOf(Vec3i chunk_vox) const { return volume(pageGridOf(chunk_vox)); }
  friend bool operator==(const PageGeometry&, const PageGeometry&) = default;
};

// Throws Error when a size is no power of two, a count is not positive, or the cache's bytes do not
// fit 63 bits. `what` starts the line ("--page 3x4x5").
void validate(const PageGeometry& geometry, std::string_view what);

// "64x32x32" -> {64, 32, 32}; nullopt when it is not three positive powers of two up to 2^20.
std::optional<Vec3i> parsePageSize(std::string_view text);
// "64x32x32".
std::string printPageSize(Vec3i size_vox);

// A machine by name.
struct PageConfiguration {
  std::string_view name;
  PageGeometry geometry;
};

// octane, octane-4mb, sparse-8, sparse-16, sparse-32.
std::span<const PageConfiguration> pageConfigurations();
// nullptr when there is none of that name.
const PageConfiguration* findPageConfiguration(std::string_view name);

}  // namespace sluice
