// The channels of a volume that a picture shows together, and how each looks: the user's wish, or
// what the file says of its channels (OME's colours, windows and active channels).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/values/volume_channels.h"
#include "src/library/requests.h"

namespace sluice {

// A channel that a picture shows. A plain value; the default is a volume of one channel.
struct ShownChannel {
  int64_t number = 0;
  std::string name = {};                  // as the file has it; may be empty
  std::string color = {};                 // a colour of --map: the file's, or a usual one
  std::optional<ValueRange> window = {};  // values that the file shows dark and bright
  // The only one of the picture: it looks like a volume of one channel, unless a look names it.
  bool is_alone = true;

  // "channel 1 (GFP)".
  std::string title() const;
};

// A volume that reads one of the channels.
struct ChannelSource {
  std::unique_ptr<VolumeSource> source;
  ShownChannel channel;
};

// Opens the volume for what reads one channel: the one of --channel, or the first. Throws as
// openSource() does.
ChannelSource openChannel(const VolumeArguments& arguments);
// Opens the volume once for each channel that pictures show: those of --channel; else the active
// ones of a file that says how its channels look, at most kMostChannels; else the first. Throws as
// openSource() does, and Error for channels that the volume does not have.
std::vector<ChannelSource> openChannels(const VolumeArguments& arguments);

// The look of a channel: what its own look among `asked.channels` says, then what `asked` says of
// all channels, then what the file says. Colours that rise over a range without other opacities
// have a ramp of opacity over the same range; light is off unless asked for.
LookArguments lookOfChannel(const LookArguments& asked, const ShownChannel& channel);
// The options that give the looks of these channels together again.
std::string lookOptions(const LookArguments& asked, const std::vector<const ShownChannel*>& shown);
// Throws Error for a look of a channel that is not shown.
void requireShown(const LookArguments& asked, const std::vector<const ShownChannel*>& shown);

}  // namespace sluice
