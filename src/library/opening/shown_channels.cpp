#include "src/library/opening/shown_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <span>
#include <utility>

#include "io/web/address.h"
#include "src/base/error.h"
#include "src/base/looks/color_word.h"
#include "src/base/values/tidy_number.h"
#include "src/library/opening/checked_source.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/opening/place_notes.h"

namespace sluice {
namespace {

// Colours that people of any colour vision tell apart come first, and two of them add up to white.
constexpr std::array<const char*, kMostChannels> kUsualColors = {
    "00ff00", "ff00ff", "00ffff", "ffff00", "ff0000", "0000ff", "ff8000", "ffffff"};

// Black adds nothing.
bool isSeen(const std::optional<std::array<double, 3>>& color) {
  return color && *color != std::array{0.0, 0.0, 0.0};
}

ShownChannel shownChannel(const VolumeSource& source, int64_t number, size_t place) {
  const auto at = static_cast<size_t>(number);
  const auto names = channelNames(source);
  const auto looks = channelLooks(source);
  const VolumeLayout& layout = source.layout();
  ShownChannel shown{.number = number, .color = kUsualColors[place]};
  if (at < names.size()) shown.name = names[at];
  if (at >= looks.size()) return shown;
  if (isSeen(looks[at].color)) shown.color = colorWord(*looks[at].color);
  if (looks[at].window) {
    const auto valueOf = [&](double stored) {
      return tidyNumber(stored * layout.value_scale + layout.value_offset);
    };
    shown.window = {valueOf(looks[at].window->lo), valueOf(looks[at].window->hi)};
  }
  return shown;
}

// The colours of channels without one: no channel gets that of another by accident.
void chooseColors(std::vector<ChannelSource>& channels, std::span<const StoredLook> looks) {
  std::set<std::string> taken;
  const auto isGiven = [&](const ChannelSource& channel) {
    const auto at = static_cast<size_t>(channel.channel.number);
    return at < looks.size() && isSeen(looks[at].color);
  };
  for (const ChannelSource& channel : channels)
    if (isGiven(channel)) taken.insert(channel.channel.color);
  for (ChannelSource& channel : channels) {
    if (isGiven(channel)) continue;
    const auto isFree = [&](const char* color) { return !taken.contains(color); };
    // There are as many usual colours as channels.
    if (!isFree(channel.channel.color.c_str()))
      channel.channel.color = *std::ranges::find_if(kUsualColors, isFree);
    taken.insert(channel.channel.color);
  }
}

// The channels that a file shows at first; one: it has no more, or does not say.
std::vector<int64_t> activeChannels(const VolumeSource& source) {
  const auto looks = channelLooks(source);
  const auto count =
      static_cast<size_t>(std::clamp<int64_t>(source.layout().channels, 0, int64_t{1} << 20));
  std::vector<int64_t> active;
  for (size_t c = 0; c < std::min(looks.size(), count) && active.size() < kMostChannels; ++c)
    if (looks[c].is_active) active.push_back(static_cast<int64_t>(c));
  if (active.empty()) active.push_back(0);
  return active;
}

}  // namespace

std::string ShownChannel::id() const {
  return is_over ? std::string(kOver) : fmt::format("{}", number);
}

std::string ShownChannel::title() const {
  if (is_over) return fmt::format("the volume over it ({})", name);
  return name.empty() ? fmt::format("channel {}", number)
                      : fmt::format("channel {} ({})", number, name);
}

ChannelSource openChannel(const VolumeArguments& arguments) {
  ChannelSource opened{openSource(arguments), {}};
  opened.channel = shownChannel(*opened.source, opened.source->layout().channel, 0);
  opened.arguments = arguments;
  return opened;
}

namespace {

// The line about a channel that the file inverts. Drawn so, the ground around its matter would be
// opaque, so that its high values are drawn bright, as those of the others.
std::string invertedNote(const VolumeSource& source, const ShownChannel& shown) {
  const auto looks = channelLooks(source);
  const auto at = static_cast<size_t>(shown.number);
  if (shown.is_alone || at >= looks.size() || !looks[at].is_inverted) return "";
  return fmt::format(
      "{}: {} is inverted in the file, which shows low values bright; here high values are bright "
      "and opaque, as in the other channels",
      source.layout().calledBy(), shown.title());
}

std::vector<ChannelSource> openOwnChannels(const VolumeArguments& arguments) {
  const ChannelWish& wish = arguments.open.channel;
  VolumeArguments first = arguments;
  const bool is_list = !wish.number && wish.name.find(',') != std::string::npos;
  if (is_list) first.open.channel = {};
  std::unique_ptr<VolumeSource> source = openSource(first);
  std::vector<int64_t> numbers{source->layout().channel};
  if (is_list)
    numbers = wishedChannels(withoutSecrets(arguments.inputs.front()), wish, channelNames(*source),
                             source->layout().channels);
  else if (!wish.given())
    numbers = activeChannels(*source);
  std::vector<ChannelSource> channels;
  for (const int64_t number : numbers) {
    ShownChannel shown = shownChannel(*source, number, channels.size());
    shown.is_alone = numbers.size() == 1;
    channels.push_back({nullptr, std::move(shown), arguments});
    channels.back().arguments.open.channel = ChannelWish(number);
  }
  chooseColors(channels, channelLooks(*source));
  // The first source serves if it reads the channel and has no note about the choice.
  if (numbers.size() == 1 && numbers.front() == source->layout().channel && !is_list) {
    channels.front().source = std::move(source);
    return channels;
  }
  source.reset();
  for (ChannelSource& channel : channels) {
    channel.source = openSource(channel.arguments);
    std::string note = invertedNote(*channel.source, channel.channel);
    if (!note.empty()) channel.notes.push_back(std::move(note));
  }
  return channels;
}

// The options that say how to read the first volume's file do not count for the other one.
VolumeArguments overArguments(const VolumeArguments& arguments) {
  VolumeArguments over{.inputs = {arguments.asked.over}};
  over.open.chunk_cache_bytes = arguments.open.chunk_cache_bytes;
  over.open.web = arguments.open.web;
  over.open.decode = arguments.open.decode;
  over.open.stop = arguments.open.stop;
  over.open.channel.is_over = true;
  return over;
}

ChannelSource openOver(const VolumeArguments& arguments, const VolumeLayout& first) {
  ChannelSource over = openChannel(overArguments(arguments));
  const std::string name = withoutSecrets(arguments.asked.over);
  over.source = withPlaceOf(first, std::move(over.source), name, over.notes);
  const VolumeLayout& layout = over.source->layout();
  if (layout.time_steps != 1 && layout.time_steps != first.time_steps)
    failRequest("{}: {} time steps, and {} has {}: a volume over another one has as many, or one",
                name, layout.time_steps, first.name, first.time_steps);
  if (layout.time_steps > 1) over.arguments.time = arguments.time;
  over.channel.is_over = true;
  over.channel.is_alone = false;
  over.channel.name = layout.name;
  const auto looks = channelLooks(*over.source);
  const auto at = static_cast<size_t>(over.channel.number);
  if (at >= looks.size() || !isSeen(looks[at].color)) over.channel.color.clear();
  std::ranges::move(placeNotes(layout, first, name), std::back_inserter(over.notes));
  return over;
}

}  // namespace

namespace {

// Tells each channel of those that are drawn with it.
std::vector<ChannelSource> drawnTogether(std::vector<ChannelSource> channels) {
  const auto voxelsOf = [](const ChannelSource& channel) {
    return static_cast<double>(volume(channel.source->layout().dims));
  };
  const auto bytesOf = [](const ChannelSource& channel) {
    return static_cast<double>(bytesPerVoxel(deviceMap(channel.source->layout()).type));
  };
  for (ChannelSource& channel : channels) {
    LayersTogether& together = channel.together;
    together.count = channels.size();
    for (const ChannelSource& other : channels) {
      together.larger = std::max(together.larger, voxelsOf(other) / voxelsOf(channel));
      together.wider = std::max(together.wider, bytesOf(other) / bytesOf(channel));
      together.have_levels |= !coarserLevels(*other.source).empty();
      together.thread_bytes = std::max(together.thread_bytes, other.source->heldBytesAThread());
    }
  }
  return channels;
}

}  // namespace

std::vector<ChannelSource> openChannels(const VolumeArguments& arguments) {
  VolumeArguments own = arguments;
  own.open.has_over = !arguments.asked.over.empty();
  std::vector<ChannelSource> channels = openOwnChannels(own);
  if (!own.open.has_over) return drawnTogether(std::move(channels));
  const VolumeLayout& first = channels.front().source->layout();
  // Each of two volumes is known by its file.
  if (channels.size() == 1 && channels.front().channel.name.empty())
    channels.front().channel.name = first.name;
  channels.push_back(openOver(arguments, first));
  return drawnTogether(std::move(channels));
}

}  // namespace sluice
