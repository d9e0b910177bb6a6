#include "tools/command_line/number.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "src/base/values/bytes.h"

namespace sluice {
namespace {

template <class Number>
std::optional<Number> parseAll(const std::string& text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, status] = std::from_chars(text.data(), end, number);
  if (status != std::errc() || stop != end) return std::nullopt;
  return number;
}

template <class Number>
std::string textOf(const NumberRange<Number>& range, const char* what) {
  using Limits = std::numeric_limits<Number>;
  const auto shown = [](Number n) {
    return std::is_same_v<Number, double> ? numberText(static_cast<double>(n))
                                          : fmt::format("{}", n);
  };
  const bool has_least = range.least != Limits::lowest(), has_most = range.most != Limits::max();
  if (has_least && range.above_least)
    return fmt::format("{} above {}{}", what, shown(range.least),
                       has_most ? ", up to " + shown(range.most) : "");
  if (has_least && has_most)
    return fmt::format("{} from {} to {}", what, shown(range.least), shown(range.most));
  if (has_least) return fmt::format("{} of at least {}", what, shown(range.least));
  if (has_most) return fmt::format("{} of at most {}", what, shown(range.most));
  return what;
}

}  // namespace

std::optional<double> parseReal(const std::string& text) {
  const auto number = parseAll<double>(text);
  // from_chars() takes "inf" and "nan", too.
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<int64_t> parseWhole(const std::string& text) {
  return parseAll<int64_t>(text);
}

std::optional<uint64_t> parseUnsigned(const std::string& text) {
  return parseAll<uint64_t>(text);
}

std::optional<int64_t> parseByteSize(const std::string& text) {
  const std::optional<uint64_t> bytes = parseBytes(text);
  return bytes && *bytes > 0 ? std::optional(static_cast<int64_t>(*bytes)) : std::nullopt;
}

std::optional<double> parseSeconds(std::string text) {
  const bool is_in_ms = text.ends_with("ms");
  text.resize(text.size() - (is_in_ms ? 2 : text.ends_with('s') ? 1 : 0));
  const std::optional<double> number = parseReal(text);
  return number ? std::optional(*number * (is_in_ms ? 1e-3 : 1)) : std::nullopt;
}

std::string rangeText(const NumberRange<double>& range) {
  return textOf(range, "a number");
}

std::string rangeText(const NumberRange<int64_t>& range) {
  return textOf(range, "a whole number");
}

std::string rangeText(const NumberRange<uint64_t>& range) {
  // 0 is the type's own end, but not obvious to people.
  NumberRange<uint64_t> shown = range;
  if (shown.least == 0 && shown.most == std::numeric_limits<uint64_t>::max())
    return "a whole number from 0 to " + fmt::format("{}", shown.most);
  return textOf(shown, "a whole number");
}

std::string numberText(double number) {
  return fmt::format("{:g}", number);
}

}  // namespace sluice
