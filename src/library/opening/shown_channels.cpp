#include "src/library/opening/shown_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "io/web/address.h"
#include "src/base/error.h"
#include "src/base/files/shell_word.h"
#include "src/base/looks/color_word.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/library/opening/checked_source.h"
#include "src/library/opening/indexed_volume.h"

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
      return stored * layout.value_scale + layout.value_offset;
    };
    shown.window = {valueOf(looks[at].window->lo), valueOf(looks[at].window->hi)};
  }
  return shown;
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

const ChannelLook* ownLook(const LookArguments& asked, const ShownChannel& channel) {
  const auto found = std::find_if(
      asked.channels.rbegin(), asked.channels.rend(),  // the last one counts
      [&](const ChannelLook& look) { return isLookOf(look, channel.number, channel.name); });
  return found == asked.channels.rend() ? nullptr : &*found;
}

bool hasOpacities(const LookArguments& look) {
  return look.threshold || !look.transfer_file.empty() || !look.opacities.empty() || look.labels;
}

}  // namespace

std::string ShownChannel::title() const {
  return name.empty() ? fmt::format("channel {}", number)
                      : fmt::format("channel {} ({})", number, name);
}

ChannelSource openChannel(const VolumeArguments& arguments) {
  ChannelSource opened{openSource(arguments), {}};
  opened.channel = shownChannel(*opened.source, opened.source->layout().channel, 0);
  return opened;
}

std::vector<ChannelSource> openChannels(const VolumeArguments& arguments) {
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
    channels.push_back({nullptr, std::move(shown)});
  }
  // The first source serves if it reads the channel and has no note about the choice.
  if (numbers.size() == 1 && numbers.front() == source->layout().channel && !is_list) {
    channels.front().source = std::move(source);
    return channels;
  }
  source.reset();
  for (ChannelSource& channel : channels) {
    VolumeArguments one = arguments;
    one.open.channel = ChannelWish(channel.channel.number);
    channel.source = openSource(one);
  }
  return channels;
}

LookArguments lookOfChannel(const LookArguments& asked, const ShownChannel& channel) {
  const ChannelLook* const own = ownLook(asked, channel);
  if (channel.is_alone && own == nullptr) return asked;
  LookArguments look = asked;
  look.channels.clear();
  const bool is_own_map = own != nullptr && !own->map.empty();
  if (is_own_map) {
    requireColorMap(own->map, "--look " + channelLookText(*own));
    look.map = own->map;
  } else if (look.map.empty() && look.transfer_file.empty() && !look.labels) {
    look.map = channel.color;
  }
  if (own != nullptr && own->opacity) look.opacity = own->opacity;
  if (!look.range) look.range = channel.window;
  if (own != nullptr && own->range) look.range = own->range;
  if (look.range && !hasOpacities(look)) {
    const auto [lo, hi] = std::minmax(look.range->lo, look.range->hi);
    look.opacities = {{lo, 0}, {hi, look.opacity.value_or(kDefaultOpacity)}};
  }
  if (!look.shade) look.no_shade = true;
  return look;
}

std::string lookOptions(const LookArguments& asked, const std::vector<const ShownChannel*>& shown) {
  std::string channels, looks;
  for (const ShownChannel* channel : shown) {
    const LookArguments look = lookOfChannel(asked, *channel);
    ChannelLook own{.channel = fmt::format("{}", channel->number), .map = look.map};
    own.range = look.range;
    if (look.range && !hasOpacities(asked))
      own.opacity = look.opacity.value_or(kDefaultOpacity);
    else
      own.opacity = look.opacity;
    channels += fmt::format("{}{}", channels.empty() ? "" : ",", channel->number);
    looks += " --look " + shellWord(channelLookText(own));
  }
  std::string text = "--channel " + channels;
  if (asked.threshold) text += fmt::format(" --threshold {}", *asked.threshold);
  if (!asked.transfer_file.empty()) text += " --transfer " + shellWord(asked.transfer_file);
  if (asked.labels) text += " --labels";
  if (!asked.label_table.empty()) text += " --labels-table " + shellWord(asked.label_table);
  for (const LabelLook& look : asked.label_looks)
    text += " --label " + shellWord(labelLookText(look));
  for (size_t i = 0; i < asked.opacities.size(); ++i)
    text += fmt::format("{}{}:{}", i == 0 ? " --opacities " : ",", asked.opacities[i].value,
                        asked.opacities[i].opacity);
  text += looks;
  if (asked.modulate) text += fmt::format(" --modulate --full-gradient {}", asked.full_gradient);
  if (asked.shade) text += " --shade";
  return text;
}

void requireShown(const LookArguments& asked, const std::vector<const ShownChannel*>& shown) {
  if (!asked.surfaces.empty() && shown.size() > 1)
    failRequest("--iso draws surfaces of one channel, not of {}; give one --channel", shown.size());
  for (const ChannelLook& look : asked.channels) {
    const bool is_shown = std::ranges::any_of(shown, [&](const ShownChannel* channel) {
      return isLookOf(look, channel->number, channel->name);
    });
    if (is_shown) continue;
    std::string list;
    for (const ShownChannel* channel : shown) list += (list.empty() ? "" : ", ") + channel->title();
    failRequest("--look {}: that channel is not shown; the picture shows {}", channelLookText(look),
                list);
  }
}

}  // namespace sluice
