#include "src/texture/fill_chunk.h"

#include <algorithm>
#include <cstring>

#include "src/base/error.h"
#include "src/texture/transposed_copy.h"

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
void copyTyped(const TextureBlock& block, const VolumeBlock& from, const Box3& used,
               const T* voxels, Vec3i storage_vox, Vec3i room, T* out) {
  const auto axes = textureAxes(block.trimming_axis);
  const Vec3i texels = block.texels(), have = from.voxels.size();
  const Vec3i strides{1, have.x, have.x * have.y};
  const Vec3i texel_stride{1, storage_vox.x, storage_vox.x * storage_vox.y};
  const auto texelAt = [&](Vec3i texel) {
    const Vec3i at = block.at + texel;
    return at.x + at.y * texel_stride.y + at.z * texel_stride.z;
  };
  // The nearest voxel that is used, relative to the volume block.
  const auto clamped = [&](int axis, int64_t texel) {
    return std::clamp(block.voxels.lo[axis] + texel, used.lo[axis], used.hi[axis] - 1) -
           from.voxels.lo[axis];
  };
  // Texels `first` to before `end` have voxels. The others repeat the nearest voxel.
  Vec3i first, end;
  for (int a = 0; a < 3; ++a) {
    const int64_t lo = block.voxels.lo[axes[a]];
    first[a] = std::clamp<int64_t>(used.lo[axes[a]] - lo, 0, texels[a]);
    end[a] = std::clamp<int64_t>(used.hi[axes[a]] - lo, first[a], texels[a]);
  }
  // The texture axis along which voxels lie side by side: unless it is x, the texels between first
  // and end are copied in planes.
  const auto side = static_cast<int>(std::ranges::find(axes, 0) - axes.begin());
  const int along = axes[0];
  for (int64_t z = 0; z < room.z; ++z)
    for (int64_t y = 0; y < room.y; ++y) {
      T* const to = out + texelAt({0, y, z}) * kNumbers;
      // The memory is recycled and its contents are arbitrary. A sample may give these texels a
      // weight of 0, for which they must be numbers.
      if (z >= texels.z || y >= texels.y) {
        fill<kNumbers>(to, room.x, T{});
        continue;
      }
      const T* line =
          voxels + clamped(axes[2], z) * strides[axes[2]] + clamped(axes[1], y) * strides[axes[1]];
      const auto at = [&](int64_t x) { return to + x * kNumbers; };
      const int64_t beside = side == 1 ? y : z;
      if (side == 0 || beside < first[side] || beside >= end[side])
        gather<kNumbers>(line + clamped(along, first.x) * strides[along], strides[along],
                         at(first.x), end.x - first.x);
      fill<kNumbers>(to, first.x, line[clamped(along, 0) * strides[along]]);
      fill<kNumbers>(at(end.x), texels.x - end.x,
                     line[clamped(along, texels.x - 1) * strides[along]]);
      fill<kNumbers>(at(texels.x), room.x - texels.x, T{});
    }
  if (side == 0) return;
  const int other = 3 - side;
  const int64_t voxel = clamped(0, first[side]);
  Vec3i texel = first;
  for (texel[other] = 0; texel[other] < texels[other]; ++texel[other]) {
    const T* const in = voxels + clamped(axes[other], texel[other]) * strides[axes[other]] +
                        clamped(along, first.x) * strides[along] + voxel;
    transposedCopy<kNumbers>(TransposedPlane<T>{in, strides[along], voxel, have.x - voxel},
                             end.x - first.x, end[side] - first[side],
                             texel_stride[side] * kNumbers, out + texelAt(texel) * kNumbers);
  }
}

}  // namespace

void copyTextureBlock(const TextureBlock& block, const VolumeBlock& from, Vec3i storage_vox,
                      Vec3i room, std::span<std::byte> out, const VoxelPlanes& planes) {
  Box3 used = from.voxels;
  for (int a = 0; a < 3; ++a)
    if (const auto plane = planes[static_cast<size_t>(a)]) {
      used.lo[a] = std::clamp(*plane, from.voxels.lo[a], from.voxels.hi[a] - 1);
      used.hi[a] = used.lo[a] + 1;
    }
  SLUICE_CHECK_EQ(out.size(), static_cast<size_t>(volume(storage_vox) * from.numbers) *
                                  bytesPerVoxel(from.type));
  SLUICE_CHECK(boxOf(storage_vox).contains(Box3{block.at, block.at + room}));
  visitDeviceType(from.type, [&](auto tag) {
    using T = decltype(tag);
    const auto* const voxels = reinterpret_cast<const T*>(from.bytes.get());
    T* const to = reinterpret_cast<T*>(out.data());
    if (from.numbers == 1) {
      copyTyped<1>(block, from, used, voxels, storage_vox, room, to);
    } else {
      copyTyped<2>(block, from, used, voxels, storage_vox, room, to);
      // A volume block keeps its spreads behind all means. A texel has its spread next to its mean,
      // so that one look-up fetches both.
      copyTyped<2>(block, from, used, voxels + from.voxels.count(), storage_vox, room, to + 1);
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
