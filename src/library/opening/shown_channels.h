// The channels of a volume that a picture shows together, and how each looks: the user's wish, or
// what the file says of its channels (OME's colours, windows and active channels).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/sources/volume_channels.h"
#include "src/base/values/value_counts.h"
#include "src/library/drawing/scene/chosen_look.h"
#include "src/library/requests.h"

namespace sluice {

// The layers of a picture, of which one is opened: for budgets before the others are known.
struct LayersTogether {
  size_t count = 1;
  double larger = 1;          // voxels of the largest one, in those of this one
  uint64_t thread_bytes = 0;  // the most that a source of them keeps decoded while a thread reads
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

// Whether a volume over another one is drawn as labels unless a look says otherwise, as far as its
// levels tell before its values are read: modes are made of labels.
bool looksLikeLabels(const ChannelSource& channel);

// The look of a channel: what its own look among `asked.channels` says, then what `asked` says of
// all channels, then what the file says. Colours that rise over a range without other opacities
// have a ramp of opacity over the same range; light is off unless asked for. For the volume over
// the first one, only its own look counts.
LookArguments lookOfChannel(const LookArguments& asked, const ShownChannel& channel);
// The same once the values are known: a volume over another one whose values are labels is drawn as
// such unless a look or its file gives it a colour, or the mode mixes the numbers of labels.
LookArguments knownLookOfChannel(const LookArguments& asked, const ShownChannel& channel,
                                 const ValueCounts& counts, Mode mode);
// The options that give the looks of these channels together again. `first`: of the first one,
// whose options are among them if it looks like a volume of one channel.
std::string lookOptions(const LookArguments& asked, const std::vector<const ShownChannel*>& shown,
                        const ChosenLook& first);
// "not 3; give one --channel": the end of a message that so many channels are shown. `last`: of
// them.
std::string notOne(size_t channels, const ShownChannel& last);
// Throws Error for a look of a channel that is not shown, and for a second look of a channel.
void requireShown(const LookArguments& asked, const std::vector<const ShownChannel*>& shown);

// The files that a look reads; some may be empty.
std::vector<std::string> filesOf(const LookArguments& look);

}  // namespace sluice
