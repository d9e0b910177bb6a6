// How each channel of a picture looks: the user's wish, or what the file says of its channels.
#pragma once

#include <string>
#include <vector>

#include "src/base/values/value_counts.h"
#include "src/library/drawing/scene/chosen_look.h"
#include "src/library/opening/shown_channels.h"
#include "src/library/requests.h"

namespace sluice {

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
