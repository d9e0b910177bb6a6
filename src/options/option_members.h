// The members of a ViewState as values of options: the types of members that an option may have,
// and how each is read and written. Used by the table of options alone. Pure functions.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "src/options/option_table.h"

namespace sluice {

using OptionWords = std::vector<std::string_view>;

// Items of lists as numbers and as texts, and back. Requires of assign(): as many numbers, or a
// text that the option takes.
OptionReals realsOf(const LookOptions::Opacity& point);
OptionReals realsOf(const PictureOptions::Plane& plane);
void assign(LookOptions::Opacity& point, const OptionReals& n);
void assign(PictureOptions::Plane& plane, const OptionReals& n);
std::string textOf(const LookOptions::Channel& channel);
void assign(LookOptions::Channel& channel, const std::string& text);
std::string textOf(const LookOptions::Label& label);
void assign(LookOptions::Label& label, const std::string& text);
std::string textOf(const LookOptions::Surface& surface);
void assign(LookOptions::Surface& surface, const std::string& text);

template <class T>
constexpr bool kIsOptionalMember = false;
template <class T>
constexpr bool kIsOptionalMember<std::optional<T>> = true;
// The alternative of OptionValue that holds such a member.
template <class T>
using AlternativeOf =
    std::conditional_t<std::is_integral_v<T> && !std::is_same_v<T, bool>, int64_t, T>;
// Things that a text says.
template <class T>
constexpr bool kIsTexts = std::is_same_v<T, std::vector<LookOptions::Channel>> ||
                          std::is_same_v<T, std::vector<LookOptions::Surface>> ||
                          std::is_same_v<T, std::vector<LookOptions::Label>>;
template <class T>
concept AnArray = requires(T array) {
  std::tuple_size<T>::value;
};
// The list that holds the numbers of an array.
template <class Array>
using ListOf =
    std::conditional_t<std::is_integral_v<typename Array::value_type>, OptionWholes, OptionReals>;

// The value of a member; nullopt if it is unset or empty.
template <class T>
std::optional<OptionValue> readMember(const OptionWords& words, const T& held) {
  if constexpr (kIsOptionalMember<T>) {
    return held ? readMember(words, *held) : std::nullopt;
  } else if constexpr (std::is_enum_v<T>) {
    return std::string(words[static_cast<size_t>(held)]);
  } else if constexpr (std::is_same_v<T, PictureOptions::Box>) {
    return OptionWholes{held.lo[0], held.lo[1], held.lo[2], held.hi[0], held.hi[1], held.hi[2]};
  } else if constexpr (std::is_arithmetic_v<T>) {
    return static_cast<AlternativeOf<T>>(held);
  } else if constexpr (AnArray<T>) {
    return ListOf<T>(held.begin(), held.end());
  } else if (held.empty()) {
    return std::nullopt;
  } else if constexpr (std::is_same_v<T, std::string>) {
    return OptionValue(held);
  } else if constexpr (kIsTexts<T>) {
    std::vector<std::string> texts;
    texts.reserve(held.size());
    for (const auto& item : held) texts.push_back(textOf(item));
    return texts;
  } else {
    std::vector<OptionReals> lists;
    lists.reserve(held.size());
    for (const auto& item : held) lists.push_back(realsOf(item));
    return lists;
  }
}

template <class T>
void writeMember(const OptionWords& words, const OptionValue& value, T& held) {
  if constexpr (kIsOptionalMember<T>) {
    writeMember(words, value, held.emplace());
  } else if constexpr (std::is_enum_v<T>) {
    const auto word = std::find(words.begin(), words.end(), std::get<std::string>(value));
    held = static_cast<T>(word - words.begin());
  } else if constexpr (std::is_same_v<T, PictureOptions::Box>) {
    const auto& n = std::get<OptionWholes>(value);
    held = {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
  } else if constexpr (AnArray<T>) {
    const auto& numbers = std::get<ListOf<T>>(value);
    for (size_t i = 0; i < held.size(); ++i)
      held[i] = static_cast<typename T::value_type>(numbers[i]);
  } else if constexpr (kIsTexts<T>) {
    held.clear();
    for (const std::string& text : std::get<std::vector<std::string>>(value))
      assign(held.emplace_back(), text);
  } else if constexpr (
      requires { held.emplace_back().opacity; } || requires { held.emplace_back().offset; }) {
    held.clear();
    for (const OptionReals& n : std::get<std::vector<OptionReals>>(value))
      assign(held.emplace_back(), n);
  } else {
    held = static_cast<T>(std::get<AlternativeOf<T>>(value));
  }
}

}  // namespace sluice
