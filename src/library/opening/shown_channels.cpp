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
#include "src/base/files/shell_word.h"
#include "src/base/looks/color_word.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/values/tidy_number.h"
#include "src/classify/transfer/automatic_look.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/library/conversions.h"
#include "src/library/opening/checked_source.h"
#include "src/library/opening/indexed_volume.h"
#include "src/library/opening/place_notes.h"
#include "src/options/option_words.h"

namespace sluice {
namespace {

// Colours that people of any colour vision tell apart come first, and two of them add up to white.
constexpr std::array<const char*, kMostChannels> kUsualColors = {
    "00ff00", "ff00ff", "00ffff", "ffff00", "ff0000", "0000ff", "ff8000", "ffffff"};

// The map of a volume over another one: it begins with black, which adds nothing.
constexpr const char* kOverMap = "hot";

// Labels over a scan: their colours are told apart, and the scan still shows its shape.
constexpr double kOverLabelsOpacity = 0.1;

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

const ChannelLook* ownLook(const LookArguments& asked, const ShownChannel& channel) {
  const auto found = std::find_if(
      asked.channels.rbegin(), asked.channels.rend(),  // the last one counts
      [&](const ChannelLook& look) { return isLookOf(look, channel.id(), channel.name); });
  return found == asked.channels.rend() ? nullptr : &*found;
}

bool hasOpacities(const LookArguments& look) {
  return look.threshold || !look.transfer_file.empty() || !look.opacities.empty() || look.labels;
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
  for (ChannelSource& channel : channels) {
    LayersTogether& together = channel.together;
    together.count = channels.size();
    for (const ChannelSource& other : channels) {
      together.larger = std::max(together.larger, voxelsOf(other) / voxelsOf(channel));
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

namespace {

// The parts of `asked` that hold for the volume over the first one, without its own look.
LookArguments sharedWithOver(const LookArguments& asked) {
  LookArguments look;
  look.this_step = asked.this_step;
  look.whole_series = asked.whole_series;
  look.first_picture = asked.first_picture;
  look.attenuation = asked.attenuation;
  look.shade = asked.shade;
  look.stop = asked.stop;
  return look;
}

LookArguments labelsOfChannel(LookArguments look, const ShownChannel& channel,
                              const ChannelLook& own) {
  look.threshold.reset();
  look.transfer_file.clear();
  look.opacities.clear();
  look.map.clear();
  look.labels = true;
  if (isLabelTable(own.map)) look.label_table = own.map;
  if (own.opacity) look.opacity = own.opacity;
  // A haze shows the volume behind it. A table has opacities of its own.
  if (!look.opacity && look.label_table.empty())
    look.opacity = channel.is_over ? kOverLabelsOpacity : kDefaultOpacity;
  return look;
}

}  // namespace

bool looksLikeLabels(const ChannelSource& channel) {
  const std::span<const CoarserLevel> levels = coarserLevels(*channel.source);
  return channel.channel.is_over && !levels.empty() && levels.front().values == LevelValues::kModes;
}

LookArguments lookOfChannel(const LookArguments& asked, const ShownChannel& channel) {
  const ChannelLook* const own = ownLook(asked, channel);
  if (channel.is_alone && own == nullptr) return asked;
  LookArguments look = channel.is_over ? sharedWithOver(asked) : asked;
  look.channels.clear();
  if (!look.shade) look.no_shade = true;
  if (own != nullptr && makesLabels(own->map))
    return labelsOfChannel(std::move(look), channel, *own);
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
  return look;
}

LookArguments knownLookOfChannel(const LookArguments& asked, const ShownChannel& channel,
                                 const ValueCounts& counts, Mode mode) {
  LookArguments look = lookOfChannel(asked, channel);
  if (!channel.is_over || !look.map.empty() || look.labels) return look;
  if (hasOpacities(look) || !traitsOf(mode).has_colors || !areLabels(counts)) {
    look.map = kOverMap;
    return look;
  }
  const ChannelLook own{.channel = channel.id(), .opacity = look.opacity};
  return labelsOfChannel(std::move(look), channel, own);
}

namespace {

// The look that gives the channel's again: "0:green,400:3000".
ChannelLook wholeLook(const LookArguments& asked, const ShownChannel& channel) {
  const LookArguments look = lookOfChannel(asked, channel);
  ChannelLook own{.channel = channel.id(), .map = look.map};
  // Labels of all channels have options of their own.
  const ChannelLook* const given = ownLook(asked, channel);
  if (given != nullptr && makesLabels(given->map)) own.map = given->map;
  own.range = look.range;
  own.opacity = look.opacity;
  if (look.range && !look.labels && !hasOpacities(channel.is_over ? LookArguments() : asked))
    own.opacity = look.opacity.value_or(kDefaultOpacity);
  return own;
}

// The options of these looks, by the table of options, with a blank in front of each. `asked`: of
// all channels, but for the parts that the looks of the channels say.
std::string optionsOf(LookArguments asked, std::vector<ChannelLook> looks, Mode mode) {
  asked.map.clear();
  asked.range.reset();
  asked.opacity.reset();
  asked.no_shade = false;
  if (!traitsOf(mode).has_colors) asked.surfaces.clear();
  asked.channels = std::move(looks);
  ViewState state;
  state.look = lookOptionsOf(asked, mode);
  return optionsText(optionWords(state, [](const OptionEntry& entry) {
    return entry.part == OptionPart::kLook && entry.option != "--mode";
  }));
}

// The options of a volume that another one lies over. --shade would light that one, too, so it is
// there only if the user gave it. Without it, the first volume is lit unless --no-shade is there.
std::string belowAnother(const ChosenLook& look, const LookArguments& asked) {
  return look.lit && !asked.shade ? look.unlit_options : look.options();
}

}  // namespace

std::string lookOptions(const LookArguments& asked, const std::vector<const ShownChannel*>& shown,
                        const ChosenLook& first_look) {
  std::string channels;
  std::vector<ChannelLook> looks;
  for (const ShownChannel* channel : shown) {
    const bool is_plain = channel->is_alone && ownLook(asked, *channel) == nullptr;
    if (!is_plain) looks.push_back(wholeLook(asked, *channel));
    if (!channel->is_over) channels += (channels.empty() ? "" : ",") + channel->id();
  }
  const ShownChannel& first = *shown.front();
  if (first.is_alone && ownLook(asked, first) == nullptr) {
    LookArguments others;
    others.combine = asked.combine;
    return belowAnother(first_look, asked) + optionsOf(others, std::move(looks), Mode::kComposite);
  }
  std::string text = optionsOf(asked, std::move(looks), first_look.mode);
  if (asked.this_step) text += " --this-step";
  // A volume's only channel needs no name, and may have none.
  if (!first.is_alone) return "--channel " + channels + text;
  return text.starts_with(' ') ? text.substr(1) : text;
}

namespace {

// A channel may be called by its number and by its name.
void requireOneLookEach(const LookArguments& asked, const ShownChannel& channel) {
  const ChannelLook* first = nullptr;
  for (const ChannelLook& look : asked.channels) {
    if (!isLookOf(look, channel.id(), channel.name)) continue;
    if (first != nullptr)
      failRequest("--look {}: {} has --look {} already; give one of them", channelLookText(look),
                  channel.title(), channelLookText(*first));
    first = &look;
  }
}

}  // namespace

void requireShown(const LookArguments& asked, const std::vector<const ShownChannel*>& shown) {
  for (const ShownChannel* channel : shown) requireOneLookEach(asked, *channel);
  const auto own = std::ranges::count(shown, false, &ShownChannel::is_over);
  if (!asked.surfaces.empty() && own > 1)
    failRequest("--iso draws surfaces of one channel, not of {}; give one --channel", own);
  for (const ChannelLook& look : asked.channels) {
    const bool is_shown = std::ranges::any_of(shown, [&](const ShownChannel* channel) {
      return isLookOf(look, channel->id(), channel->name);
    });
    if (is_shown) continue;
    std::string list;
    for (const ShownChannel* channel : shown) list += (list.empty() ? "" : ", ") + channel->title();
    failRequest("--look {}: that channel is not shown; the picture shows {}", channelLookText(look),
                list);
  }
}

std::string notOne(size_t channels, const ShownChannel& last) {
  std::string line = fmt::format("not {}; ", channels);
  if (channels > 2 || !last.is_over) line += "give one --channel";
  if (last.is_over) line += channels > 2 ? " and leave out --over" : "leave out --over";
  return line;
}

std::vector<std::string> filesOf(const LookArguments& look) {
  std::vector<std::string> files{look.transfer_file, look.label_table};
  for (const ChannelLook& channel : look.channels)
    if (isLabelTable(channel.map)) files.push_back(channel.map);
  return files;
}

}  // namespace sluice
