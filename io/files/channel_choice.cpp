#include "io/files/channel_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr int64_t kMostNamed = 8;

std::string shown(int64_t channel, std::span<const std::string> names) {
  const auto at = static_cast<size_t>(channel);
  return at < names.size() && !names[at].empty() ? fmt::format("{} ({})", channel, names[at])
                                                 : fmt::format("{}", channel);
}

// "1 (GFP), 2, ... 11".
std::string listed(int64_t first, int64_t count, std::span<const std::string> names) {
  std::string list;
  for (int64_t c = first; c < count && c < kMostNamed; ++c)
    list += fmt::format("{}{}", list.empty() ? "" : ", ", shown(c, names));
  if (count > kMostNamed) list += fmt::format(", ... {}", count - 1);
  return list;
}

int64_t numberOf(const std::string& path, const std::string& name,
                 std::span<const std::string> names, int64_t channels) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (name.empty() || found == names.end() || found - names.begin() >= channels)
    fail("{}: --channel {}: the volume has no channel of that name, expected one of {}", path, name,
         listed(0, channels, names));
  if (std::find(found + 1, names.end(), name) != names.end())
    fail("{}: --channel {}: several channels have that name, expected a number: {}", path, name,
         listed(0, channels, names));
  return found - names.begin();
}

}  // namespace

void chooseChannel(const std::string& path, const ChannelWish& wish,
                   std::span<const std::string> names, VolumeLayout& layout) {
  if (wish.number && (*wish.number < 0 || *wish.number >= layout.channels))
    fail("{}: --channel {}: the volume has {} channel{}, counted from 0", path, *wish.number,
         layout.channels, layout.channels == 1 ? "" : "s");
  layout.channel = wish.number.value_or(0);
  if (!wish.number && wish.given())
    layout.channel = numberOf(path, wish.name, names, layout.channels);
  if (wish.given() || layout.channels < 2) return;
  layout.notes.push_back(fmt::format("{}: channel {} of {} is read; --channel takes {}", path,
                                     shown(0, names), layout.channels,
                                     listed(1, layout.channels, names)));
}

}  // namespace sluice
