// How a command gets its options: in groups of at most twelve, each under a heading of --help, one
// call an option. The call gives the names, the placeholder, the target, the range and the help;
// the default shown is the target's value at that moment.
//
//   OptionGroup view(app, "View");
//   view.number("--zoom", "FACTOR", options.camera.zoom, {0, 1e6, true}, "1 fits the volume");
//   view.choice("--mode", modes(), options.mode, "How samples along a ray combine");
//   view.flag("--shade", look.shade, "Gradient Phong lighting");
//   view.rare().number("--fov", "DEGREES", camera.fov, {1, 179}, "Vertical field of view");
//
// A value that is refused is a usage error with the option's name, the allowed values, the value
// found, and the word that was probably meant.
#pragma once

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <concepts>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/base/values/text_parts.h"
#include "src/base/values/vec.h"
#include "tools/command_line/number.h"

namespace sluice {

// The words of an option that takes one of a few, and their values.
template <class Value>
using Words = std::vector<std::pair<std::string, Value>>;

// A word for each value of the list, by `name_of`.
template <class Value, class List, class Name>
Words<Value> wordsOf(const List& values, Name name_of) {
  Words<Value> words;
  for (const Value& value : values) words.emplace_back(std::string(name_of(value)), value);
  return words;
}

template <class Value>
std::vector<std::string> namesOf(const Words<Value>& words) {
  std::vector<std::string> names;
  for (const auto& [word, value] : words) names.push_back(word);
  return names;
}

// "composite|mip|minip|average"
std::string joined(const std::vector<std::string>& words, const std::string& between);
// "composite, mip, minip or average"
std::string listed(const std::vector<std::string>& words);

// Refuses an empty word of a positional option that takes names, as OptionGroup::text() does.
CLI::Option* requireNames(CLI::Option* option);

// The words that an option of an OptionGroup takes, for completions; empty if it takes any text.
std::vector<std::string> offeredWords(CLI::Option& option);

class OptionGroup {
 public:
  // The most that one heading may hold.
  static constexpr size_t kMostOptions = 12;

  // `app` must outlive the call alone.
  OptionGroup(CLI::App& app, std::string heading) : app_(app), heading_(std::move(heading)) {}

  // The same group for options that pictures rarely need: the --help of the commands that draw
  // leaves them out.
  OptionGroup rare() const {
    OptionGroup group(*this);
    group.is_rare_ = true;
    return group;
  }

  CLI::Option* flag(const std::string& names, bool& on, const std::string& help) const;
  // A flag without a variable of its own; `take` is called if it is given.
  CLI::Option* flag(const std::string& names, const std::function<void()>& take,
                    const std::string& help) const;

  // double, int64_t, uint64_t, int, or an optional of these.
  template <class Number>
  CLI::Option* number(const std::string& names, const std::string& what, Number& target,
                      const NumberRange<double>& range, const std::string& help)
      const requires std::same_as<Number, double> || std::same_as<Number, std::optional<double>> {
    return ranged(names, what, target, range, help);
  }
  template <class Number>
  CLI::Option* number(const std::string& names, const std::string& what, Number& target,
                      const NumberRange<int64_t>& range,
                      const std::string& help) const requires std::same_as<Number, int64_t> ||
      std::same_as<Number, std::optional<int64_t>> || std::same_as<Number, int> {
    return ranged(names, what, target, range, help);
  }
  CLI::Option* number(const std::string& names, const std::string& what, uint64_t& target,
                      const NumberRange<uint64_t>& range, const std::string& help) const {
    return ranged(names, what, target, range, help);
  }

  // `count` numbers of the range with commas between; `take` gets them. `shown`: the default.
  CLI::Option* numbers(const std::string& names, const std::string& what, size_t count,
                       const NumberRange<double>& range,
                       const std::function<void(const std::vector<double>&)>& take,
                       const std::string& help, const std::string& shown = "") const;

  // A size in bytes from 1 up: 512M.
  CLI::Option* bytes(const std::string& names, uint64_t& target, const std::string& help) const;

  // Accepts any text but the empty one: a file's name.
  CLI::Option* text(const std::string& names, const std::string& what, std::string& target,
                    const std::string& help) const;

  // An option that takes one of these words, which `take` gets. `also` accepts more words than
  // those that are shown; messages name them as `others`.
  CLI::Option* word(const std::string& names, const std::vector<std::string>& words,
                    const std::function<void(const std::string&)>& take, const std::string& help,
                    const std::string& shown = "",
                    const std::function<bool(const std::string&)>& also = nullptr,
                    const std::string& others = "") const;

  // The same for words that have values. `also` understands more words than those that are shown,
  // and messages name them as `others`.
  template <class Value, class Target>
  CLI::Option* choice(const std::string& names, const Words<Value>& words, Target& target,
                      const std::string& help,
                      const std::function<std::optional<Value>(const std::string&)>& also = nullptr,
                      const std::string& others = "") const {
    std::string shown;
    if constexpr (std::same_as<Target, Value>)
      for (const auto& [word, value] : words)
        if (value == target) shown = word;
    const auto take = [=, &target](const std::string& given) {
      for (const auto& [known, value] : words)
        if (given == known) {
          target = value;
          return;
        }
      target = *also(given);
    };
    return word(
        names, namesOf(words), take, help, shown,
        [also](const std::string& given) { return also && also(given); }, others);
  }

  // Accepts several of a few words, with commas between.
  template <class Value>
  CLI::Option* choices(const std::string& names, const Words<Value>& words,
                       std::vector<Value>& target, const std::string& help) const {
    const auto take = [=, &target](const std::string& given) {
      target.clear();
      for (const std::string_view word : split(given, ',')) {
        const auto known = std::find_if(words.begin(), words.end(),
                                        [&](const auto& each) { return each.first == word; });
        if (known == words.end()) refuseWord(longName(names), std::string(word), namesOf(words));
        target.push_back(known->second);
      }
    };
    return offering(add(names, "NAME,...", help, take), namesOf(words));
  }

  // Anything else: `parse` turns the word into a value (nullopt: it is refused, and the message
  // names `expected`), `take` gets it.
  template <class Parse, class Take>
  CLI::Option* parsed(const std::string& names, const std::string& what,
                      const std::string& expected, Parse parse, Take take, const std::string& help,
                      const std::string& shown = "") const {
    return add(names, what, help,
               [=](const std::string& word) {
                 const auto value = parse(word);
                 if (!value) refuse(longName(names), word, expected);
                 take(*value);
               })
        ->default_str(shown);
  }

  // A flag that may have a value after "=": alone it means `bare`.
  template <class Parse, class Take>
  CLI::Option* valuedFlag(const std::string& name, const std::string& bare,
                          const std::string& expected, Parse parse, Take take,
                          const std::string& help) const {
    const auto check = [=](const std::string& word) {
      const auto value = parse(word);
      // The parser puts the name in front.
      if (!value) throw CLI::ValidationError("expected " + expected + ", found '" + word + "'");
      take(*value);
    };
    return placed(app_.add_flag(name + "{" + bare + "}", help)->each(check));
  }

 private:
  CLI::Option* add(const std::string& names, const std::string& what, const std::string& help,
                   const std::function<void(const std::string&)>& take) const;
  // Puts the option under the heading.
  CLI::Option* placed(CLI::Option* option) const;
  // Keeps the words for offeredWords().
  static CLI::Option* offering(CLI::Option* option, const std::vector<std::string>& words);
  // The placeholder of the value in --help: the words if they are few, else NAME.
  static std::string chooseName(const std::vector<std::string>& words);
  // The parts between commas.
  // The long name of "-s,--size".
  static std::string longName(const std::string& names);
  [[noreturn]] static void refuse(const std::string& name, const std::string& found,
                                  const std::string& expected);
  [[noreturn]] static void refuseWord(const std::string& name, const std::string& found,
                                      const std::vector<std::string>& words,
                                      const std::string& others = "");

  template <class Target, class Number>
  CLI::Option* ranged(const std::string& names, const std::string& what, Target& target,
                      const NumberRange<Number>& range, const std::string& help) const {
    std::string shown;
    if constexpr (requires { target.has_value(); }) {
      if (target) shown = numberText(static_cast<double>(*target));
    } else if constexpr (std::same_as<Number, double>) {
      shown = numberText(target);
    } else {
      shown = std::to_string(target);
    }
    return parsed(
        names, what, rangeText(range),
        [range](const std::string& word) { return parseIn(word, range); },
        [&target](Number number) {
          if constexpr (std::same_as<Target, int>) {
            target = static_cast<int>(number);
          } else {
            target = number;
          }
        },
        help, shown);
  }

  CLI::App& app_;
  const std::string heading_;
  bool is_rare_ = false;
};

// The long names of the options that the command line gives: "--fov". To be taken before a saved
// view is applied, since its options are kept for the pictures in which they count.
std::set<std::string> givenOptions(const CLI::App& app);

}  // namespace sluice
