// ChannelLook: how one of several channels looks that are drawn together, as an option says it:
// `0:green,400:3000,0.1`. Pure functions.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "src/base/sources/volume_source.h"

namespace sluice {

// Channels that a picture shows together at the most.
inline constexpr size_t kMostChannels = 8;

// The channel's id in a look of the volume that is drawn over the first one.
inline constexpr std::string_view kOver = "over";

// In a map's place: values are labels, each with its colour. A table of labels does the same.
inline constexpr std::string_view kLabelsMap = "labels";

// Whether a map is the file of a table of labels: names of maps and colours have neither '.' nor
// '/'.
bool isLabelTable(std::string_view map);
// Whether a map makes labels of values.
inline bool makesLabels(std::string_view map) {
  return map == kLabelsMap || isLabelTable(map);
}

// Whatever is not set follows from the file, or from the values.
struct ChannelLook {
  std::string channel;                   // its number from 0, its name, or kOver; not empty
  std::string map = {};                  // a colour, a map, kLabelsMap or a file; empty: not set
  std::optional<ValueRange> range = {};  // colours span it, and opacity rises over it; lo != hi
  std::optional<double> opacity = {};    // at the end of the range, of a voxel length; 0 to 1
  friend bool operator==(const ChannelLook&, const ChannelLook&) = default;
};

// "0:green", "0:green,400:3000", "DAPI:0000ff,400:3000,0.1", "1:,400:3000"; nullopt: no such text.
// The name ends at the last colon in front of the first comma.
std::optional<ChannelLook> parseChannelLook(std::string_view text);
// The text that gives the look again.
std::string channelLookText(const ChannelLook& look);
// Whether the look is meant for the channel of this id ("2" for the channel of that number) and
// name.
bool isLookOf(const ChannelLook& look, std::string_view id, std::string_view name);

}  // namespace sluice
