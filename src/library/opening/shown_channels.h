// The channels of a volume that a picture shows together: those that the user asks for, or what the
// file says of its channels (OME's names, colours, windows and active channels).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/sources/volume_channels.h"
#include "src/library/requests.h"

namespace sluice {

// The layers of a picture, of which one is opened: for budgets before the others are known.
struct LayersTogether {
  size_t count = 1;
  double larger = 1;          // voxels of the largest one, in those of this one
  double wider = 1;           // bytes of a voxel of the widest one, in those of this one
  uint64_t thread_bytes = 0;  // the most that a source of them keeps decoded while a thread reads
  bool have_levels = false;   // one of them or more
};

// A channel that a picture shows, or the volume that it shows over the first one. A plain value;
// the default is a volume of one channel.
struct ShownChannel {
  int64_t number = 0;
  bool is_over = false;                   // of VolumeOptions::over
  std::string name = {};                  // as the file has it, or the file's; may be empty
  std::string color = {};                 // a colour of --map: the file's, or a usual one
  std::optional<ValueRange> window = {};  // values that the file shows dark and bright
  // The only one of the picture: it looks like a volume of one channel, unless a look names it.
  bool is_alone = true;

  // "1", or kOver.
  std::string id() const;
  // "channel 1 (GFP)", "the volume over it (seg.nii.gz)".
  std::string title() const;
};

// A volume that reads one of the channels.
struct ChannelSource {
  std::unique_ptr<VolumeSource> source;
  ShownChannel channel;
  VolumeArguments arguments = {};       // that open it again
  std::vector<std::string> notes = {};  // for people, one line each
  LayersTogether together = {};
};

// Opens the volume for what reads one channel: the one of --channel, or the first. Throws as
// openSource() does.
ChannelSource openChannel(const VolumeArguments& arguments);
// Opens the volume once for each channel that pictures show: those of --channel; else the active
// ones of a file that says how its channels look, at most kMostChannels; else the first. The last
// one is the first channel of the volume over it, if there is one. Throws as openSource() does, and
// Error for channels that the volume does not have, or a volume over it of other time steps.
std::vector<ChannelSource> openChannels(const VolumeArguments& arguments);

}  // namespace sluice
