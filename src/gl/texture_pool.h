// TexturePool: level 4's textures, reused and not re-created.
//
// Storage that a driver sees for the first time is slow to fill (software GL: some hundred MB/s
// against ten GB/s), so an evicted chunk's texture waits for the next chunk of its size. The one
// that waited longest is taken first: a driver that still draws from the last ones would wait for
// itself. Idle textures never exceed spareTextureBytes() beyond the most bytes that were resident
// at once. One thread, the context's.
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <span>

#include "src/base/values/vec.h"
#include "src/device/device.h"
#include "src/gl/contexts/gl_functions.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

class TexturePool {
 public:
  // `gl` must outlive the pool, and its context be current in every call, the destructor included.
  explicit TexturePool(const GlFunctions& gl) : gl_(gl) {}
  ~TexturePool();
  TexturePool(const TexturePool&) = delete;
  TexturePool& operator=(const TexturePool&) = delete;

  // A texture's format: numbers of one type, one or two a texel.
  struct Format {
    DeviceType type = DeviceType::kU8;
    bool has_spread = false;
    friend auto operator<=>(const Format&, const Format&) = default;
  };

  // A texture of exactly `size_vox` texels holding `texels`. Throws Error when the driver has no
  // memory for it.
  GLuint take(Vec3i size_vox, Format format, std::span<const std::byte> texels);
  void giveBack(GLuint texture, Vec3i size_vox, Format format);

  uint64_t uploadedBytes() const { return uploaded_bytes_; }

 private:
  struct Size {
    int64_t x, y, z;
    Format format;
    friend auto operator<=>(const Size&, const Size&) = default;
  };
  GLuint create(Vec3i size_vox, Format format);
  void dropIdle(uint64_t bytes);

  const GlFunctions& gl_;
  std::map<Size, std::deque<GLuint>> idle_;
  uint64_t used_bytes_ = 0, idle_bytes_ = 0, most_used_bytes_ = 0;
  uint64_t uploaded_bytes_ = 0;
};

}  // namespace sluice
