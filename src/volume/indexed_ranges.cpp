#include "src/volume/indexed_ranges.h"

namespace sluice {

IndexedRanges indexedRanges(VolumeSource& source, int64_t time, const BlockLayout& layout,
                            WorkerPool& pool) {
  IndexedRanges result;
  const VolumeLayout& voxels = source.layout();
  Progress progress("indexing",
                    static_cast<uint64_t>(voxels.dims.x * voxels.dims.y * voxels.dims.z) *
                        bytesPerVoxel(voxels.type));
  result.ranges = buildSliceRanges(source, time, layout, pool, progress);
  result.state = "built, not kept";
  return result;
}

}  // namespace sluice
