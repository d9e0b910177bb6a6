#include "io/zarr/zarr_rows.h"

#include <algorithm>
#include <cstring>

namespace sluice {
namespace {

template <class Word>
void copyStrided(const std::byte* from, int64_t stride, std::byte* to, int64_t count) {
  for (int64_t i = 0; i < count; ++i)
    std::memcpy(to + i * static_cast<int64_t>(sizeof(Word)),
                from + i * stride * static_cast<int64_t>(sizeof(Word)), sizeof(Word));
}

}  // namespace

std::vector<int64_t> stridesInChunk(const ZarrArray& array) {
  std::vector<int64_t> strides(array.axes());
  int64_t stride = 1;
  for (size_t i = 0; i < array.axes(); ++i) {
    const size_t axis = array.order[array.axes() - 1 - i];
    strides[axis] = stride;
    stride *= array.chunks[axis];
  }
  return strides;
}

void copyRow(const std::byte* from, int64_t stride, std::byte* to, int64_t count, size_t voxel) {
  if (stride == 1) {
    std::memcpy(to, from, static_cast<size_t>(count) * voxel);
    return;
  }
  if (voxel == 1) copyStrided<uint8_t>(from, stride, to, count);
  if (voxel == 2) copyStrided<uint16_t>(from, stride, to, count);
  if (voxel == 4) copyStrided<uint32_t>(from, stride, to, count);
  if (voxel == 8) copyStrided<uint64_t>(from, stride, to, count);
}

void fillRow(std::span<const std::byte> voxel, std::byte* to, int64_t count) {
  const size_t bytes = voxel.size() * static_cast<size_t>(count);
  if (bytes == 0) return;
  std::memcpy(to, voxel.data(), voxel.size());
  for (size_t done = voxel.size(); done < bytes;) {  // in doubling steps
    const size_t more = std::min(done, bytes - done);
    std::memcpy(to + done, to, more);
    done += more;
  }
}

}  // namespace sluice
