#include <cmath>
#include <string>

#include "io/zarr/packing/zarr_writer.h"
#include "src/base/error.h"

namespace sluice {
namespace {

std::string words(Vec3d v) {
  return fmt::format("({:g}, {:g}, {:g})", v.x, v.y, v.z);
}

// The difference of a channel from the first, which one array cannot hold; empty: none.
std::string differenceOf(const VolumeLayout& other, const VolumeLayout& first) {
  if (other.dims != first.dims || other.time_steps != first.time_steps)
    return fmt::format("has {} x {} x {} voxels in {} time steps, the first {} x {} x {} in {}",
                       other.dims.x, other.dims.y, other.dims.z, other.time_steps, first.dims.x,
                       first.dims.y, first.dims.z, first.time_steps);
  if (other.type != first.type)
    return fmt::format("has voxels of {}, the first of {}", name(other.type), name(first.type));
  if (other.value_scale != first.value_scale || other.value_offset != first.value_offset)
    return fmt::format("has values of stored * {:g} + {:g}, the first of stored * {:g} + {:g}",
                       other.value_scale, other.value_offset, first.value_scale,
                       first.value_offset);
  // Files give numbers of six digits or more.
  constexpr double kSlack = 1e-6;
  const double scale = length(first.spacing);
  bool is_turned = false;
  for (size_t a = 0; a < 3; ++a)
    is_turned = is_turned || length(other.axes[a] - first.axes[a]) > kSlack;
  if (length(other.spacing - first.spacing) > kSlack * scale || is_turned)
    return fmt::format("has voxels that are {} apart{}, the first {}", words(other.spacing),
                       is_turned ? " in other directions" : "", words(first.spacing));
  if (length(other.origin - first.origin) > kSlack * (scale + length(first.origin)))
    return fmt::format("begins at {}, the first at {}", words(other.origin), words(first.origin));
  return "";
}

}  // namespace

uint64_t packedBytes(ChannelSources channels) {
  const VolumeLayout& layout = channels.front()->layout();
  for (const VolumeSource* channel : channels)
    if (const std::string difference = differenceOf(channel->layout(), layout); !difference.empty())
      failRequest(
          "{}: channel {} {}: a store has channels that are alike; pack each with --channel",
          layout.calledBy(), channel->layout().channel, difference);
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
