#include "io/zarr/reading/zarr_rows.h"

#include <algorithm>
#include <cstring>

namespace sluice {

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
