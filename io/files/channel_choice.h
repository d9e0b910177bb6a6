// Which channel of several is read: what a user wants, by number or by name, and what a volume says
// of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "src/base/volume_source.h"

namespace sluice {

struct ChannelWish {
  std::optional<int64_t> number = {};  // from 0
  std::string name = {};               // where there is no number; both empty: the first channel

  ChannelWish() = default;
  ChannelWish(int64_t wanted) : number(wanted) {}
  ChannelWish(std::optional<int64_t> wanted, std::string wanted_name)
      : number(wanted), name(std::move(wanted_name)) {}

  bool given() const { return number || !name.empty(); }
  // As it is written behind --channel.
  std::string text() const { return number ? std::to_string(*number) : name; }
};

// Sets layout.channel to what is wanted of the layout's channels. `names` may be fewer than those.
// Without a wish a volume of several channels gets a note: which one is read, what the others are,
// how to choose. Throws Error, which starts with `path`, for a channel that it does not have, or a
// name that several have.
void chooseChannel(const std::string& path, const ChannelWish& wish,
                   std::span<const std::string> names, VolumeLayout& layout);

}  // namespace sluice
