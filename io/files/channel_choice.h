// The choice of one channel among several: the user's wish, by number or by name, and the channels
// that a volume names.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

struct ChannelWish {
  std::optional<int64_t> number = {};  // from 0
  // Used if there is no number; perhaps several, see wishedChannels(). Both empty: the first
  // channel.
  std::string name = {};
  // The volume lies over another one (--over), of which the first channel is read.
  bool is_over = false;
  // The name is the first time step's, and not the user's.
  bool is_of_series = false;

  ChannelWish() = default;
  ChannelWish(int64_t wanted) : number(wanted) {}
  ChannelWish(std::optional<int64_t> wanted, std::string wanted_name)
      : number(wanted), name(std::move(wanted_name)) {}

  bool given() const { return number || !name.empty(); }
  // The text as written after --channel.
  std::string text() const { return number ? std::to_string(*number) : name; }
};

// The channels that a wish names: "0,2" or "DAPI,GFP" as well as one channel. A name of the
// volume's that has a comma is one channel. Throws Error, which starts with `path`, for a channel
// that it does not have, one that comes twice, and more than kMostChannels.
std::vector<int64_t> wishedChannels(const std::string& path, const ChannelWish& wish,
                                    std::span<const std::string> names, int64_t channels);

// Sets layout.channel to the wanted one of the layout's channels. `names` may be fewer than those.
// Without a wish, a volume of several channels gets a note: which one is read, the names of the
// others, and how to choose. Throws Error, which starts with `path`, for a channel that it does not
// have, or a name that several have.
void chooseChannel(const std::string& path, const ChannelWish& wish,
                   std::span<const std::string> names, VolumeLayout& layout);

}  // namespace sluice
