#include "src/texture/fill_chunk.h"

#include <algorithm>
#include <cstring>

#include "src/base/error.h"

namespace sluice {
namespace {

// Copies `count` elements that lie `stride` elements apart to places kNumbers elements apart.
template <int kNumbers, class T>
void gather(const T* from, int64_t stride, T* to, int64_t count) {
  if (kNumbers == 1 && stride == 1) {
    std::memcpy(to, from, static_cast<size_t>(count) * sizeof(T));
  } else {
    for (int64_t i = 0; i < count; ++i) to[i * kNumbers] = from[i * stride];
  }
}

template <int kNumbers, class T>
void fill(T* to, int64_t count, T value) {
  if constexpr (kNumbers == 1)
    std::fill(to, to + count, value);
  else
    for (int64_t i = 0; i < count; ++i) to[i * kNumbers] = value;
}

// One number of each texel: those of `voxels`, to places kNumbers elements apart from `out` on.
template <int kNumbers, class T>
void copyTyped(const TextureBlock& block, const VolumeBlock& from, const T* voxels,
               Vec3i storage_vox, Vec3i room, T* out) {
  const auto axes = textureAxes(block.trimming_axis);
  const Vec3i texels = block.texels(), have = from.voxels.size();
  const Vec3i strides{1, have.x, have.x * have.y};
  // The nearest voxel that exists, relative to the volume block.
  const auto clamped = [&](int axis, int64_t texel) {
    return std::clamp(block.voxels.lo[axis] + texel, from.voxels.lo[axis],
                      from.voxels.hi[axis] - 1) -
           from.voxels.lo[axis];
  };
  // Voxels `first` to `end` of a row are there. The others lie outside the volume and repeat the
  // nearest one.
  const int along = axes[0];
  const int64_t first =
      std::clamp<int64_t>(from.voxels.lo[along] - block.voxels.lo[along], 0, texels.x);
  const int64_t end =
      std::clamp<int64_t>(from.voxels.hi[along] - block.voxels.lo[along], first, texels.x);
  for (int64_t z = 0; z < room.z; ++z)
    for (int64_t y = 0; y < room.y; ++y) {
      const int64_t texel =
          ((block.at.z + z) * storage_vox.y + block.at.y + y) * storage_vox.x + block.at.x;
      T* const to = out + texel * kNumbers;
      // The memory is recycled and its contents are arbitrary. A sample may give these texels a
      // weight of 0, for which they must be numbers.
      if (z >= texels.z || y >= texels.y) {
        fill<kNumbers>(to, room.x, T{});
        continue;
      }
      const T* line =
          voxels + clamped(axes[2], z) * strides[axes[2]] + clamped(axes[1], y) * strides[axes[1]];
      const auto at = [&](int64_t x) { return to + x * kNumbers; };
      gather<kNumbers>(line + clamped(along, first) * strides[along], strides[along], at(first),
                       end - first);
      fill<kNumbers>(to, first, line[clamped(along, 0) * strides[along]]);
      fill<kNumbers>(at(end), texels.x - end, line[clamped(along, texels.x - 1) * strides[along]]);
      fill<kNumbers>(at(texels.x), room.x - texels.x, T{});
    }
}

}  // namespace

void copyTextureBlock(const TextureBlock& block, const VolumeBlock& from, Vec3i storage_vox,
                      Vec3i room, std::span<std::byte> out) {
  SLUICE_CHECK_EQ(out.size(), static_cast<size_t>(volume(storage_vox) * from.numbers) *
                                  bytesPerVoxel(from.type));
  SLUICE_CHECK(boxOf(storage_vox).contains(Box3{block.at, block.at + room}));
  visitDeviceType(from.type, [&](auto tag) {
    using T = decltype(tag);
    const auto* const voxels = reinterpret_cast<const T*>(from.bytes.get());
    T* const to = reinterpret_cast<T*>(out.data());
    if (from.numbers == 1) {
      copyTyped<1>(block, from, voxels, storage_vox, room, to);
    } else {
      copyTyped<2>(block, from, voxels, storage_vox, room, to);
      // A volume block keeps its spreads behind all means. A texel has its spread next to its mean,
      // so that one look-up fetches both.
      copyTyped<2>(block, from, voxels + from.voxels.count(), storage_vox, room, to + 1);
    }
  });
}

std::vector<Vec3i> roomsOf(const TexturePlan& plan, const Chunk& chunk, Vec3i storage_vox) {
  // Columns along x or y, the first at 0, each listed from below: a block's room ends where the
  // next block of its column, or the next column, begins.
  std::vector<Vec3i> rooms(chunk.blocks.size());
  Vec3i end = storage_vox, next = storage_vox;
  // Walks from the last block to the first: `next` is where the block behind begins, `end` the
  // upper corner of the room.
  for (size_t i = rooms.size(); i-- > 0;) {
    const Vec3i at = plan.blocks[chunk.blocks[i]].at;
    for (const int a : {0, 1})
      if (i + 1 < rooms.size() && at[a] != next[a]) {
        end = storage_vox;
        end[a] = next[a];
      }
    next = at;
    rooms[i] = end - at;
    // The block below in this column ends where this one begins.
    end.z = at.z;
  }
  return rooms;
}

}  // namespace sluice
