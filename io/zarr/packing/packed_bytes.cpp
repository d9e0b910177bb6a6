#include "io/zarr/packing/zarr_writer.h"
#include "src/base/error.h"

namespace sluice {

uint64_t packedBytes(ChannelSources channels) {
  const VolumeLayout& layout = channels.front()->layout();
  const auto count = static_cast<int64_t>(channels.size());
  // Divided step by step, so that no product can wrap.
  const int64_t most_volumes = kMostVolumeVoxels / volume(layout.dims);
  if (layout.time_steps > most_volumes / count)
    failRequest(
        "{}: expected at most 2^59 voxels in all, found {} x {} x {} in {} time step{} and {} "
        "channel{}; pack a part of them",
        layout.calledBy(), layout.dims.x, layout.dims.y, layout.dims.z, layout.time_steps,
        layout.time_steps == 1 ? "" : "s", count, count == 1 ? "" : "s");
  return static_cast<uint64_t>(volume(layout.dims) * layout.time_steps * count) *
         bytesPerVoxel(layout.type);
}

}  // namespace sluice
