// Voxels that lie apart, copied to a packed row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace sluice {

// copyRow() for one length of voxels, which the compiler then copies without a call.
template <size_t bytes>
void copyWords(const std::byte* from, int64_t stride, std::byte* to, int64_t count) {
  for (int64_t i = 0; i < count; ++i)
    std::memcpy(to + i * static_cast<int64_t>(bytes), from + i * stride, bytes);
}

// `stride`: bytes between neighbours, of any sign. `voxel_bytes`: 1, 2, 4 or 8.
inline void copyRow(const std::byte* from, int64_t stride, std::byte* to, int64_t count,
                    size_t voxel_bytes) {
  if (stride == static_cast<int64_t>(voxel_bytes))
    std::memcpy(to, from, static_cast<size_t>(count) * voxel_bytes);
  else if (voxel_bytes == 1)
    copyWords<1>(from, stride, to, count);
  else if (voxel_bytes == 2)
    copyWords<2>(from, stride, to, count);
  else if (voxel_bytes == 4)
    copyWords<4>(from, stride, to, count);
  else
    copyWords<8>(from, stride, to, count);
}

}  // namespace sluice
