#include "src/options/option_rules.h"

#include <fmt/format.h>

#include <array>
#include <vector>

#include "src/base/looks/channel_look.h"
#include "src/options/option_entries.h"

namespace sluice {
namespace {

// Labels have opacities of their own. --opacities may stand beside --transfer, whose points it
// replaces.
constexpr std::array kApart = std::to_array<OptionPair>({
    {"--threshold", "--transfer"},
    {"--threshold", "--opacities"},
    {"--opacities", "--opacity"},
    {"--threshold", "--labels"},
    {"--threshold", "--labels-table"},
    {"--threshold", "--label"},
    {"--transfer", "--labels"},
    {"--transfer", "--labels-table"},
    {"--transfer", "--label"},
    {"--opacities", "--labels"},
    {"--opacities", "--labels-table"},
    {"--opacities", "--label"},
    {"--iso", "--labels"},
    {"--iso", "--labels-table"},
    {"--iso", "--label"},
    {"--no-shade", "--shade"},
    {"--eye", "--view"},
    {"--eye", "--azimuth"},
    {"--eye", "--elevation"},
    {"--eye", "--fit"},
    {"--level", "--pixel-error"},
    {"--level", "--max-bytes"},
    {"--level", "--keep-thin"},
});

constexpr std::array kNeeds = std::to_array<OptionPair>({
    {"--eye", "--target"},
    {"--target", "--eye"},
    {"--full-gradient", "--modulate"},
});

bool isNotUnlit(const ViewState& state) {
  return state.look.light != LookOptions::Light::kOff;
}

// A value of the option, unless it is 0 or an empty list, needs a view that fits.
struct ValueRule {
  std::string_view option;
  bool (*fits)(const ViewState&);
  std::string_view reason;  // follows the option in messages
};

constexpr std::string_view kNotLit = "needs --mode composite, since other modes are not lit";
constexpr std::string_view kLights = "lights the picture; leave out --no-shade";

constexpr std::string_view kMixed =
    "needs --mode composite, since other modes mix the numbers of labels";

constexpr std::array kValueRules = std::to_array<ValueRule>({
    {"--iso", hasColors, "needs --mode composite, since other modes show one value a pixel"},
    {"--shadows", hasColors, kNotLit},
    {"--occlusion-light", hasColors, kNotLit},
    {"--shadows", isNotUnlit, kLights},
    {"--occlusion-light", isNotUnlit, kLights},
    {"--depth-cueing", hasColors, "needs --mode composite"},
    {"--jitter", hasColors, "needs --mode composite"},
    // Both others make labels of the values.
    {"--label", hasColors, kMixed},
    {"--labels-table", hasColors, kMixed},
    {"--labels", hasColors, kMixed},
});

// The value that asks for nothing. Requires: the option takes a number, surfaces or labels.
OptionValue nothingOf(const OptionEntry& entry) {
  switch (entry.kind.form) {
    case OptionForm::kSurfaces:
    case OptionForm::kLabels:
      return std::vector<std::string>();
    case OptionForm::kFlag:
      return false;
    case OptionForm::kFile:
      return std::string();
    default:
      return 0.0;
  }
}

bool isBroken(const ValueRule& rule, const ViewState& state) {
  const OptionEntry& entry = optionEntry(rule.option);
  const std::optional<OptionValue> value = entry.get(state);
  return value && *value != nothingOf(entry) && !rule.fits(state);
}

bool makesMixedLabels(const LookOptions& look, const LookOptions::Channel& channel) {
  return look.mode != LookOptions::Mode::kComposite && makesLabels(channel.map);
}

}  // namespace

std::span<const OptionPair> optionsApart() {
  return kApart;
}

std::span<const OptionPair> optionNeeds() {
  return kNeeds;
}

std::optional<std::string> conflictIn(const ViewState& state) {
  for (const ValueRule& rule : kValueRules)
    if (isBroken(rule, state)) return fmt::format("{} {}", rule.option, rule.reason);
  for (const LookOptions::Channel& channel : state.look.channels)
    if (makesMixedLabels(state.look, channel))
      return fmt::format("--look {} {}", textOf(channel), kMixed);
  return std::nullopt;
}

ViewState withoutConflicts(ViewState state) {
  for (const ValueRule& rule : kValueRules)
    if (isBroken(rule, state)) clearOption(rule.option, state);
  std::erase_if(state.look.channels, [&](const LookOptions::Channel& channel) {
    return makesMixedLabels(state.look, channel);
  });
  return state;
}

void clearOption(std::string_view option, ViewState& state) {
  const OptionEntry& entry = optionEntry(option);
  entry.set(state, nothingOf(entry));
}

PictureOptions pictureOf(const ViewState& state, int width, int height) {
  PictureOptions picture = withoutConflicts(state);
  picture.width = width;
  picture.height = height;
  return picture;
}

LookOptions lookOf(const ViewState& state) {
  return withoutConflicts(state).look;
}

}  // namespace sluice
