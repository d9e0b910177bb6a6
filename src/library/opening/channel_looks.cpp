#include "src/library/opening/channel_looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "src/base/error.h"
#include "src/base/sources/volume_levels.h"
#include "src/classify/transfer/automatic_look.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/library/conversions.h"
#include "src/options/option_words.h"

namespace sluice {
namespace {

// The map of a volume over another one: it begins with black, which adds nothing.
constexpr const char* kOverMap = "hot";

// Labels over a scan: their colours are told apart, and the scan still shows its shape.
constexpr double kOverLabelsOpacity = 0.1;

const ChannelLook* ownLook(const LookArguments& asked, const ShownChannel& channel) {
  const auto found = std::find_if(
      asked.channels.rbegin(), asked.channels.rend(),  // the last one counts
      [&](const ChannelLook& look) { return isLookOf(look, channel.id(), channel.name); });
  return found == asked.channels.rend() ? nullptr : &*found;
}

bool hasOpacities(const LookArguments& look) {
  return look.threshold || !look.transfer_file.empty() || !look.opacities.empty() || look.labels;
}

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
  if (!look.range && channel.window) {
    look.range = channel.window;
    // Colours of a ramp begin at its threshold, unless the user gives a range.
    const double top = std::max(look.range->lo, look.range->hi);
    if (look.threshold && *look.threshold < top) look.range = ValueRange{*look.threshold, top};
  }
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
