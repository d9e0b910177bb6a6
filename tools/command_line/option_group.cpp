#include "tools/command_line/option_group.h"

#include <fmt/format.h>

#include <iterator>
#include <sstream>

#include "tools/command_line/help.h"
#include "tools/command_line/near_miss.h"
#include "tools/command_line/parse.h"

namespace sluice {

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string listed(const std::vector<std::string>& words) {
  if (words.size() < 2) return joined(words, "");
  const std::vector<std::string> head(words.begin(), words.end() - 1);
  return joined(head, ", ") + " or " + words.back();
}

constexpr const char* kExpectedName = "a name that is not empty";

// The words are the description of a validator that is switched off: it checks and shows nothing.
constexpr const char* kOffered = "offered words";

CLI::Option* requireNames(CLI::Option* option) {
  // The parser puts the option's name in front.
  return option->check([](const std::string& word) {
    return word.empty() ? fmt::format("expected {}, found ''", kExpectedName) : std::string();
  });
}

std::vector<std::string> offeredWords(CLI::Option& option) {
  CLI::Validator offered;
  try {
    offered = *option.get_validator(kOffered);
  } catch (const CLI::OptionNotFound&) {
    return {};
  }
  std::istringstream text(offered.active(true).get_description());
  return {std::istream_iterator<std::string>(text), {}};
}

CLI::Option* OptionGroup::offering(CLI::Option* option, const std::vector<std::string>& words) {
  CLI::Validator offered(joined(words, " "));
  return option->check(offered.active(false), kOffered);
}

CLI::Option* OptionGroup::flag(const std::string& names, bool& on, const std::string& help) const {
  // A value is refused in usage.cpp, by the word that was given.
  return placed(app_.add_flag(names, on, help)->disable_flag_override());
}

CLI::Option* OptionGroup::flag(const std::string& names, const std::function<void()>& take,
                               const std::string& help) const {
  const auto told = [take](const std::string& /*word*/) { take(); };
  return placed(app_.add_flag(names, help)->each(told)->disable_flag_override());
}

CLI::Option* OptionGroup::numbers(const std::string& names, const std::string& what, size_t count,
                                  const NumberRange<double>& range,
                                  const std::function<void(const std::vector<double>&)>& take,
                                  const std::string& help, const std::string& shown) const {
  const auto parse = [=](const std::string& word) {
    auto found = parseNumbers(word, count);
    if (found)
      for (const double n : *found)
        if (!range.holds(n)) return std::optional<std::vector<double>>();
    return found;
  };
  return parsed(names, what, fmt::format("{}, each {}", what, rangeText(range)), parse, take, help,
                shown);
}

CLI::Option* OptionGroup::bytes(const std::string& names, uint64_t& target,
                                const std::string& help) const {
  return parsed(
      names, "BYTES", kByteSizes, parseByteSize,
      [&target](int64_t size) { target = static_cast<uint64_t>(size); }, help);
}

CLI::Option* OptionGroup::text(const std::string& names, const std::string& what,
                               std::string& target, const std::string& help) const {
  const auto parse = [](const std::string& word) {
    return word.empty() ? std::nullopt : std::optional(word);
  };
  return parsed(
      names, what, kExpectedName, parse, [&target](const std::string& word) { target = word; },
      help);
}

CLI::Option* OptionGroup::word(const std::string& names, const std::vector<std::string>& words,
                               const std::function<void(const std::string&)>& take,
                               const std::string& help, const std::string& shown,
                               const std::function<bool(const std::string&)>& also,
                               const std::string& others) const {
  const auto check = [=](const std::string& given) {
    const bool is_known = std::find(words.begin(), words.end(), given) != words.end();
    if (!is_known && !(also && also(given))) refuseWord(longName(names), given, words, others);
    take(given);
  };
  return offering(add(names, chooseName(words), help, check), words)->default_str(shown);
}

CLI::Option* OptionGroup::add(const std::string& names, const std::string& what,
                              const std::string& help,
                              const std::function<void(const std::string&)>& take) const {
  return placed(app_.add_option_function<std::string>(names, take, help)->type_name(what));
}

CLI::Option* OptionGroup::placed(CLI::Option* option) const {
  if (is_rare_) noteRare(app_, *option);
  return option->group(heading_);
}

std::string OptionGroup::chooseName(const std::vector<std::string>& words) {
  constexpr size_t kMostLetters = 44;
  const std::string all = joined(words, "|");
  return all.size() <= kMostLetters ? all : "NAME";
}

std::string OptionGroup::longName(const std::string& names) {
  const size_t dashes = names.find("--");
  if (dashes == std::string::npos) return names;
  return names.substr(dashes, names.find(',', dashes) - dashes);
}

void OptionGroup::refuse(const std::string& name, const std::string& found,
                         const std::string& expected) {
  throw CLI::ValidationError(fmt::format("{}: expected {}, found '{}'", name, expected, found));
}

void OptionGroup::refuseWord(const std::string& name, const std::string& found,
                             const std::vector<std::string>& words, const std::string& others) {
  const std::string meant = nearest(found, words);
  const std::string more = others.empty() ? "" : ", or " + others;
  throw CLI::ValidationError(fmt::format("{}: expected {}{}, found '{}'{}", name, listed(words),
                                         more, found,
                                         meant.empty() ? "" : "; did you mean " + meant + "?"));
}

std::set<std::string> givenOptions(const CLI::App& app) {
  std::set<std::string> given;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0) given.insert(option->get_name());
  return given;
}

}  // namespace sluice
