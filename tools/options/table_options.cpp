#include "tools/options/table_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"
#include "src/options/option_rules.h"
#include "src/options/option_table.h"
#include "src/view/state/view_check.h"
#include "tools/command_line/parse.h"

namespace sluice {
namespace {

// "40:0,60:0.1".
std::optional<OptionValue> pointsOf(const std::string& word) {
  return parseList<OptionReals>(word, [](std::string pair) -> std::optional<OptionReals> {
    const size_t colon = pair.find(':');
    if (colon == std::string::npos) return std::nullopt;
    pair[colon] = ',';
    return parseNumbers(pair, 2);
  });
}

// "300:0.4,1200".
std::optional<OptionValue> surfacesOf(const std::string& word) {
  return parseList<std::string>(word, [](const std::string& surface) {
    return parseSurfaceLook(surface) ? std::optional(surface) : std::nullopt;
  });
}

std::optional<OptionValue> wholesOf(const OptionReals& numbers) {
  OptionWholes wholes;
  for (const double n : numbers) {
    // Beyond 2^53 a double skips whole numbers.
    if (n != std::floor(n) || std::abs(n) > 0x1p53) return std::nullopt;
    wholes.push_back(static_cast<int64_t>(n));
  }
  return wholes;
}

// One number for all axes, or one each.
std::optional<OptionValue> spacingOf(const std::string& word) {
  if (const auto one = parseNumbers(word, 1)) return OptionReals(3, one->front());
  return parseNumbers(word, 3);
}

std::optional<OptionValue> dimsOf(const std::string& word) {
  auto numbers = parseNumbers(word, 3);
  if (!numbers) numbers = parseNumbers(word, 4);
  return numbers ? wholesOf(*numbers) : std::nullopt;
}

// A word of digits is a number, whatever the channels are called.
std::optional<OptionValue> channelOf(const std::string& word) {
  if (word.empty()) return std::nullopt;
  if (word.find_first_not_of("+-0123456789") != std::string::npos) return word;
  return parseWhole(word);
}

// The value that a word of the entry's form says, in range or not; nullopt: it is no such word.
std::optional<OptionValue> readWord(const auto& entry, const std::string& word) {
  switch (entry.kind.form) {
    case OptionForm::kWhole:
      return parseIn<int64_t>(word, wholesIn(entry.kind.limits));
    case OptionForm::kBytes:
      return parseByteSize(word);
    case OptionForm::kNumber:
      return parseReal(word);
    case OptionForm::kSeconds:
      return parseSeconds(word);
    case OptionForm::kFlag:
      return word == entry.kind.words[1];
    case OptionForm::kWord:
      if (const auto meant = entry.kind.meant) return std::string(meant(word).value_or(word));
      return word;
    case OptionForm::kFile:
    case OptionForm::kName:
      return word.empty() ? std::nullopt : std::optional<OptionValue>(word);
    case OptionForm::kChannel:
      return channelOf(word);
    case OptionForm::kSpacing:
      return spacingOf(word);
    case OptionForm::kDims:
      return dimsOf(word);
    case OptionForm::kChannels:
      return parseChannelLook(word) ? std::optional<OptionValue>(std::vector<std::string>{word})
                                    : std::nullopt;
    case OptionForm::kLabels:
      return parseLabelLook(word) ? std::optional<OptionValue>(std::vector<std::string>{word})
                                  : std::nullopt;
    case OptionForm::kSurfaces:
      return surfacesOf(word);
    case OptionForm::kPoints:
      return pointsOf(word);
    case OptionForm::kColor: {
      const auto color = parseColor(word);
      if (!color) return std::nullopt;
      return OptionReals(color->begin(), color->end());
    }
    default:
      break;
  }
  const auto numbers = parseNumbers(word, numbersOf(entry.kind.form));
  if (!numbers) return std::nullopt;
  if (entry.kind.form == OptionForm::kBox) return wholesOf(*numbers);
  if (entry.kind.form == OptionForm::kPlanes) return std::vector<OptionReals>{*numbers};
  const bool is_pair =
      entry.kind.form == OptionForm::kRange || entry.kind.form == OptionForm::kAngles;
  if (is_pair && word.find('x') != std::string::npos) return std::nullopt;  // "0x10" is none
  return *numbers;
}

std::string expectedOf(const auto& entry) {
  std::string range = rangeText(entry.kind.limits);
  switch (entry.kind.form) {
    case OptionForm::kChannel:
      return fmt::format("a channel's number from 0 to {:.0f}, or its name",
                         entry.kind.limits.most);
    case OptionForm::kSpacing:
      return "one number or X,Y,Z, each" + range.substr(std::string_view("a number").size());
    case OptionForm::kDims:
      return "whole numbers X,Y,Z or X,Y,Z,T, each from 1 to 2^40";
    case OptionForm::kName:
    case OptionForm::kFile:
      return "a name that is not empty";
    case OptionForm::kRange:
      return "two different numbers LO,HI";
    case OptionForm::kColor:
      return "six hexadecimal digits RRGGBB";
    case OptionForm::kBox:
      return "six whole numbers X0,Y0,Z0,X1,Y1,Z1 from 0 to 2^40, each upper one above the lower";
    case OptionForm::kChannels:
      return "a channel and its colour, perhaps a range of values and an opacity from 0 to 1, such "
             "as 0:green,400:3000,0.1";
    case OptionForm::kLabels:
      return "a label N, a whole number, labels N-M or all, and their colour or opacity from 0 to "
             "1, such as "
             "3=ff8800:0.4";
    case OptionForm::kSurfaces:
      return fmt::format(
          "up to {} values T, T:A or T:A:COLOR with an opacity from 0 to 1 and a colour, such as "
          "1200,300:0.4:ff8800",
          kMostSurfaces);
    case OptionForm::kPoints:
      return "pairs V:A of values, ascending, and opacities from 0 to 1";
    case OptionForm::kWhole:
      return rangeText(wholesIn(entry.kind.limits));
    case OptionForm::kBytes:
      return kByteSizes;
    case OptionForm::kNumber:
      return range;
    case OptionForm::kSeconds:
      return range + ", also with a unit, as in 1s or 500ms";
    default:
      return fmt::format("{}, each {}", entry.value, range);
  }
}

// The default in --help; empty for what is not set.
template <class Subject>
std::string shownOf(const EntryOf<Subject>& entry, const Subject& asked) {
  const std::optional<OptionValue> value = entry.get(asked);
  if (!value) return "";
  if (entry.kind.form == OptionForm::kWhole) return fmt::format("{}", std::get<int64_t>(*value));
  if (entry.kind.form == OptionForm::kNumber) return numberText(std::get<double>(*value));
  return entry.kind.form == OptionForm::kWord ? std::get<std::string>(*value) : "";
}

// The channel or labels that both looks determine, of which the picture could show the last alone;
// empty: none.
std::string givenTwice(OptionForm form, const std::string& earlier, const std::string& later) {
  if (form == OptionForm::kChannels) {
    const auto a = parseChannelLook(earlier), b = parseChannelLook(later);
    return a->channel == b->channel ? "channel " + b->channel : "";
  }
  const auto a = parseLabelLook(earlier), b = parseLabelLook(later);
  const bool adds =
      (a->color.empty() || b->color.empty()) && !(a->opacity.has_value() && b->opacity.has_value());
  if (adds || a->first != b->first || a->last != b->last) return "";
  return "label " + later.substr(0, later.find('='));
}

void requireOnce(const auto& entry, const std::vector<std::string>& earlier,
                 const std::string& later) {
  for (const std::string& each : earlier)
    if (const std::string twice = givenTwice(entry.kind.form, each, later); !twice.empty())
      throw CLI::ValidationError(
          fmt::format("{} {}: {} is given twice", entry.option, later, twice));
}
void requireOnce(const auto& /*entry*/, const std::vector<OptionReals>& /*earlier*/,
                 const OptionReals& /*later*/) {}

// The planes, or looks of channels or labels, asked for so far, and one more.
template <class Subject, class Lists>
OptionValue oneMore(const EntryOf<Subject>& entry, const Subject& asked, const Lists& one) {
  Lists all = std::get<Lists>(entry.get(asked).value_or(Lists()));
  requireOnce(entry, all, one.front());
  all.push_back(one.front());
  if (const auto fault = faultOf(entry.kind, all))
    throw CLI::ValidationError(fmt::format("{}: {}", entry.option, fault->expected));
  return all;
}

bool isGivenAgain(OptionForm form) {
  return form == OptionForm::kPlanes || form == OptionForm::kChannels ||
         form == OptionForm::kLabels;
}

// The value together with those that were given earlier, if the option may be given again.
template <class Subject>
OptionValue withEarlier(const EntryOf<Subject>& entry, const Subject& asked,
                        const OptionValue& value) {
  if (entry.kind.form == OptionForm::kPlanes)
    return oneMore(entry, asked, std::get<std::vector<OptionReals>>(value));
  if (isGivenAgain(entry.kind.form))
    return oneMore(entry, asked, std::get<std::vector<std::string>>(value));
  return value;
}

const std::vector<OptionEntry>& tableOf(const ViewState& /*asked*/) {
  return optionTable();
}
const std::vector<VolumeEntry>& tableOf(const VolumeOptions& /*asked*/) {
  return volumeTable();
}

}  // namespace

template <class Subject>
CLI::Option* TableOptionsOf<Subject>::add(const std::string& names, const std::string& shown,
                                          const std::string& heading) const {
  const EntryOf<Subject>& entry = entryIn(tableOf(*asked_), names.substr(names.find("--")));
  const OptionGroup all(app_, heading.empty() ? std::string(entry.heading) : heading);
  const OptionGroup group = entry.is_rare ? all.rare() : all;
  const auto parse = [&entry](const std::string& word) {
    auto value = readWord(entry, word);
    return value && !faultOf(entry.kind, *value) ? value : std::nullopt;
  };
  const auto keep = [&entry, take = take_, asked = asked_](const OptionValue& value) {
    entry.set(*asked, withEarlier(entry, *asked, value));
    take(*asked);
  };
  const std::string help(entry.help), as_default = shown.empty() ? shownOf(entry, *asked_) : shown;
  const std::vector<std::string> words(entry.kind.words.begin(), entry.kind.words.end());
  if (entry.kind.form == OptionForm::kFlag && words.empty())
    return group.flag(
        names, [keep] { keep(true); }, help);
  if (!entry.kind.bare.empty())
    return group.valuedFlag(names, std::string(entry.kind.bare), expectedOf(entry), parse, keep,
                            help);
  if (!words.empty())
    return group.word(
        names, words, [keep, parse](const std::string& word) { keep(*parse(word)); }, help,
        as_default,
        [meant = entry.kind.meant](const std::string& word) {
          return meant != nullptr && meant(word);
        });
  CLI::Option* added = group.parsed(names, std::string(entry.value), expectedOf(entry), parse, keep,
                                    help, as_default);
  return isGivenAgain(entry.kind.form) ? added->trigger_on_parse() : added;
}

template <class Subject>
void TableOptionsOf<Subject>::addRest(std::string_view heading, OptionPart part) const {
  for (const EntryOf<Subject>& entry : tableOf(*asked_)) {
    const std::string option(entry.option);
    if (entry.heading == heading && entry.part == part && !option.empty() &&
        app_.get_option_no_throw(option) == nullptr)
      add(option);
  }
}

template class TableOptionsOf<ViewState>;
template class TableOptionsOf<VolumeOptions>;

void pairOptions(CLI::App& command) {
  const auto forEach = [&command](std::span<const OptionPair> pairs, auto pair) {
    for (const auto& [one, other] : pairs) {
      CLI::Option* const first = command.get_option_no_throw(std::string(one));
      CLI::Option* const second = command.get_option_no_throw(std::string(other));
      if (first != nullptr && second != nullptr) pair(first, second);
    }
  };
  forEach(optionsApart(), [](CLI::Option* one, CLI::Option* other) { one->excludes(other); });
  forEach(optionNeeds(), [](CLI::Option* one, CLI::Option* other) { one->needs(other); });
  for (CLI::App* each : command.get_subcommands(nullptr)) pairOptions(*each);
}

}  // namespace sluice
