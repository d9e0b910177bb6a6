#include "io/files/channel_choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "src/base/error.h"
#include "src/base/files/number_text.h"
#include "src/base/looks/channel_look.h"
#include "src/base/values/text_parts.h"

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

void requireNumber(const std::string& path, int64_t number, int64_t channels) {
  if (number < 0 || number >= channels)
    failRequest("{}: --channel {}: the volume has {} channel{}, counted from 0", path, number,
                channels, channels == 1 ? "" : "s");
}

int64_t numberOf(const std::string& path, const std::string& name,
                 std::span<const std::string> names, int64_t channels) {
  const auto found = std::find(names.begin(), names.end(), name);
  // A name may have a comma in it, so that a list is tried only if no channel is called so.
  if (found == names.end() && name.find(',') != std::string::npos) {
    wishedChannels(path, {std::nullopt, name}, names, channels);  // throws for a wrong one
    failRequest("{}: --channel {}: one channel is read here, expected one of {}", path, name,
                listed(0, channels, names));
  }
  if (name.empty() || found == names.end() || found - names.begin() >= channels)
    failRequest("{}: --channel {}: the volume has no channel of that name, expected one of {}",
                path, name, listed(0, channels, names));
  if (std::find(found + 1, names.end(), name) != names.end())
    failRequest("{}: --channel {}: several channels have that name, expected a number: {}", path,
                name, listed(0, channels, names));
  return found - names.begin();
}

}  // namespace

std::vector<int64_t> wishedChannels(const std::string& path, const ChannelWish& wish,
                                    std::span<const std::string> names, int64_t channels) {
  std::vector<int64_t> wished;
  const auto add = [&](int64_t channel) {
    if (std::ranges::find(wished, channel) != wished.end())
      failRequest("{}: --channel {}: channel {} comes twice", path, wish.text(),
                  shown(channel, names));
    wished.push_back(channel);
  };
  const bool is_one = wish.number || std::ranges::find(names, wish.name) != names.end() ||
                      wish.name.find(',') == std::string::npos;
  if (is_one) {
    if (wish.number) requireNumber(path, *wish.number, channels);
    add(wish.number ? *wish.number : numberOf(path, wish.name, names, channels));
    return wished;
  }
  for (const std::string_view part : split(wish.name, ',')) {
    const std::string word(part);
    if (word.empty())
      failRequest("{}: --channel {}: expected a channel on both sides of each comma", path,
                  wish.text());
    const auto number = numberIn<int64_t>(word);
    if (number) requireNumber(path, *number, channels);
    add(number ? *number : numberOf(path, word, names, channels));
  }
  if (wished.size() > kMostChannels)
    failRequest("{}: --channel {}: {} channels, a picture shows {} together at the most", path,
                wish.text(), wished.size(), kMostChannels);
  return wished;
}

void chooseChannel(const std::string& path, const ChannelWish& wish,
                   std::span<const std::string> names, VolumeLayout& layout) {
  if (wish.number) requireNumber(path, *wish.number, layout.channels);
  layout.channel = wish.number.value_or(0);
  if (wish.is_of_series && std::ranges::count(names, wish.name) != 1)
    fail(
        "{}: expected a channel called {} as in the first time step, found {}; all time steps "
        "must have it once",
        path, wish.name, listed(0, layout.channels, names));
  if (!wish.number && wish.given())
    layout.channel = numberOf(path, wish.name, names, layout.channels);
  if (wish.given() || layout.channels < 2) return;
  if (wish.is_over) {
    layout.notes.push_back(fmt::format(
        "{}: channel {} of {} is read, as of every volume of --over; to draw another one, copy it "
        "with sluice pack --channel",
        path, shown(0, names), layout.channels));
    return;
  }
  layout.notes.push_back(fmt::format("{}: channel {} of {} is read; --channel takes {}", path,
                                     shown(0, names), layout.channels,
                                     listed(1, layout.channels, names)));
}

}  // namespace sluice
